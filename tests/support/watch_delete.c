/* Preloaded: touching a deleted C++ object of the size of pythonfmu's PyState
   block is a segmentation fault, at once and always.

   Such objects get a page of their own, which is closed when they are deleted. */

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>

#define WATCHED 128
#define PAGE 4096

void *_Znwm(size_t size) { /* operator new(size_t) */
    if (size != WATCHED) {
        void *block = malloc(size ? size : 1);
        if (!block) abort();
        return block;
    }
    void *page = mmap(NULL, PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (page == MAP_FAILED) abort();
    return page;
}

void _ZdlPv(void *block) { /* operator delete(void *) */
    if (block && (uintptr_t)block % PAGE == 0)
        mprotect(block, PAGE, PROT_NONE);
    else
        free(block);
}

void _ZdlPvm(void *block, size_t size) { /* operator delete(void *, size_t) */
    (void)size;
    _ZdlPv(block);
}
