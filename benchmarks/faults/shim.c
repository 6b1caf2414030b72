/* Counts the operations on files below one folder, or the pieces of memory that are asked for, and
   lets the process die or fail at one of them.

   Preloaded; does nothing until it is armed. Built by arena.py where there is a compiler. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static char below[4096];
static long counted, due = -1;
static int code, lasting;
static char ours[65536];

void arm(const char *folder, long number, int error, int forever) {
    strncpy(below, folder, sizeof below - 1);
    counted = 0, due = number, code = error, lasting = forever;
}

long operations(void) { return counted; }

/* Whether this operation is to fail; a code of 0 kills instead. */
static int strikes(void) {
    if (due < 0) return 0;
    counted++;
    if (counted != due && !(lasting && due > 0 && counted > due)) return 0;
    if (code == 0) kill(getpid(), SIGKILL);
    errno = code;
    return 1;
}

/* The process stands in the folder: a relative path leads there. */
static int of_path(const char *path) {
    return below[0] && path && (path[0] != '/' || strncmp(path, below, strlen(below)) == 0);
}
static int of_file(int file) { return file >= 0 && file < (int)sizeof ours && ours[file]; }

#define REAL(name) __typeof__(&name) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

#define OPEN(name)                                              \
    int name(const char *path, int flags, ...) {                \
        REAL(name);                                             \
        va_list rest;                                           \
        va_start(rest, flags);                                  \
        mode_t mode = va_arg(rest, mode_t);                     \
        va_end(rest);                                           \
        int mine = of_path(path);                               \
        if (mine && strikes()) return -1;                       \
        int file = real(path, flags, mode);                     \
        if (file >= 0 && file < (int)sizeof ours) ours[file] = mine; \
        return file;                                            \
    }
OPEN(open)
OPEN(open64)

#define ON_FILE(type, name, parameters, arguments)    \
    type name parameters {                            \
        REAL(name);                                   \
        if (of_file(file) && strikes()) return -1;    \
        return real arguments;                        \
    }
ON_FILE(ssize_t, pwrite, (int file, const void *data, size_t size, off_t at), (file, data, size, at))
ON_FILE(ssize_t, pwrite64, (int file, const void *data, size_t size, off64_t at), (file, data, size, at))
ON_FILE(ssize_t, write, (int file, const void *data, size_t size), (file, data, size))
ON_FILE(int, fsync, (int file), (file))
ON_FILE(int, ftruncate, (int file, off_t size), (file, size))
ON_FILE(int, ftruncate64, (int file, off64_t size), (file, size))

/* A file whose close fails is closed. */
int close(int file) {
    REAL(close);
    int fails = of_file(file) && strikes(), error = errno;
    if (file >= 0 && file < (int)sizeof ours) ours[file] = 0;
    int result = real(file);
    if (fails) errno = error;
    return fails ? -1 : result;
}

#define ON_PATH(name, parameters, arguments)          \
    int name parameters {                             \
        REAL(name);                                   \
        if (of_path(path) && strikes()) return -1;    \
        return real arguments;                        \
    }
ON_PATH(rename, (const char *path, const char *other), (path, other))
ON_PATH(link, (const char *path, const char *other), (path, other))
ON_PATH(unlink, (const char *path), (path))
ON_PATH(rmdir, (const char *path), (path))
ON_PATH(mkdir, (const char *path, mode_t mode), (path, mode))

/* Memory: what a library of C gets by `new`, what numpy gets, and Python's objects that are not
   small. The functions of glibc itself, since dlsym asks for memory too. */
extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *old, size_t size);

static long wanted, refused = -1;
static int for_good;

void arm_memory(long number, int forever) { wanted = 0, refused = number, for_good = forever; }

long allocations(void) { return wanted; }

static int is_refused(void) {
    if (refused < 0) return 0;
    long number = __sync_add_and_fetch(&wanted, 1);
    if (number != refused && !(for_good && number > refused)) return 0;
    errno = ENOMEM;
    return 1;
}

void *malloc(size_t size) { return is_refused() ? NULL : __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return is_refused() ? NULL : __libc_calloc(count, size); }
void *realloc(void *old, size_t size) { return is_refused() ? NULL : __libc_realloc(old, size); }
