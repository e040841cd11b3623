/* A host that is not Python: runs an FMU's shared library and times its calls.

   c_host LIBRARY RESOURCES_URI STEPS BAD_TEXT LOGGING MASS
   prints: status of the last step, outputs of reals 0..2, microseconds per
   (set, step, get), status of leaving initialization mode. With BAD_TEXT = 1
   the first string is set to text that is not UTF-8 before the last step. MASS,
   if not 0, is given to real 1. No status stops it. Messages go to stderr. */

#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef void *component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

static void logger(void *env, const char *name, int status, const char *category,
                   const char *format, ...) {
    va_list arguments;
    (void)env; (void)category;
    fprintf(stderr, "[%s %d] ", name, status);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void *library;

static void *symbol(const char *name) {
    void *found = dlsym(library, name);
    if (!found) { fprintf(stderr, "no %s\n", name); exit(2); }
    return found;
}

int main(int count, char **arguments) {
    callbacks functions = {logger, calloc, free, NULL, NULL};
    unsigned references[3] = {0, 1, 2}, first = 0;
    double values[3] = {1.0, 0.0, 0.0};
    const char *bad = "\xff\xfe";
    long steps = count > 3 ? atol(arguments[3]) : 0;
    int status = 0, left;
    struct timespec begin, end;
    component c;

    library = count > 6 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (!library) { fprintf(stderr, "cannot load: %s\n", dlerror()); return 2; }
    component (*instantiate)(const char *, int, const char *, const char *, const callbacks *, int,
                             int) = symbol("fmi2Instantiate");
    int (*setup)(component, int, double, double, int, double) = symbol("fmi2SetupExperiment");
    int (*enter)(component) = symbol("fmi2EnterInitializationMode");
    int (*leave)(component) = symbol("fmi2ExitInitializationMode");
    int (*step)(component, double, double, int) = symbol("fmi2DoStep");
    int (*set)(component, const unsigned *, size_t, const double *) = symbol("fmi2SetReal");
    int (*get)(component, const unsigned *, size_t, double *) = symbol("fmi2GetReal");
    int (*say)(component, const unsigned *, size_t, const char *const *) = symbol("fmi2SetString");
    int (*terminate)(component) = symbol("fmi2Terminate");
    void (*release)(component) = symbol("fmi2FreeInstance");

    c = instantiate("c host", 1, "", arguments[2], &functions, 0,
                    atoi(arguments[5]));
    if (!c) { fprintf(stderr, "not instantiated\n"); return 3; }
    setup(c, 0, 0.0, 0.0, 0, 0.0);
    enter(c);
    values[1] = atof(arguments[6]);
    if (values[1] != 0.0) set(c, references + 1, 1, values + 1);
    left = leave(c);
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (long i = 0; i < steps; i++) {
        set(c, references, 1, values);
        if (i == steps - 1 && atoi(arguments[4])) say(c, &first, 1, &bad);
        status = step(c, i * 1e-4, 1e-4, 1);
        get(c, references, 3, values);
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    double duration = (end.tv_sec - begin.tv_sec) + 1e-9 * (end.tv_nsec - begin.tv_nsec);
    terminate(c);
    release(c);
    dlclose(library);
    printf("%d %.17g %.17g %.17g %.3f %d\n", status, values[0], values[1], values[2],
           steps ? 1e6 * duration / steps : 0.0, left);
    return 0;
}
