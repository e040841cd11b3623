/* Preloaded: touching a deleted C++ object of the size of pythonfmu's PyState
   block is a segmentation fault, at once and always.

   Such objects get a page of their own out of one reserved range, which is
   closed when they are deleted and not used again. Only the range tells them
   from other memory: malloc may return page-aligned blocks too. */

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>

#define WATCHED 128
#define PAGE ((size_t)4096)
#define PAGES ((size_t)65536)

static char *range;
static size_t used; /* counted atomically: objects are made in several threads */

__attribute__((constructor)) static void reserve(void) {
    range = mmap(NULL, PAGE * PAGES, PROT_READ | PROT_WRITE,
                 MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (range == MAP_FAILED) abort();
}

void *_Znwm(size_t size) { /* operator new(size_t) */
    if (size == WATCHED && range) {
        size_t page = __atomic_fetch_add(&used, 1, __ATOMIC_RELAXED);
        if (page < PAGES) return range + page * PAGE;
    }
    void *block = malloc(size ? size : 1);
    if (!block) abort();
    return block;
}

void _ZdlPv(void *block) { /* operator delete(void *) */
    uintptr_t place = (uintptr_t)block, first = (uintptr_t)range;
    if (range && place >= first && place < first + PAGE * PAGES)
        mprotect(block, PAGE, PROT_NONE);
    else
        free(block);
}

void _ZdlPvm(void *block, size_t size) { /* operator delete(void *, size_t) */
    (void)size;
    _ZdlPv(block);
}
