/* Ends the process before a chosen call that changes a file, or in the middle of it: preloaded, it stands in front of
 * the C library. `faults_begin(folder, at, torn)` counts from then on the calls on files inside `folder`; call number
 * `at` does not come back. With `torn`, a write first writes half of its bytes. `faults_count()` tells how many there
 * were. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static char folder[4096];
static long counted, fatal = -1;
static int torn;

void faults_begin(const char *inside, long at, int half) {
    strncpy(folder, inside, sizeof folder - 1);
    counted = 0;
    fatal = at;
    torn = half;
}

long faults_count(void) { return counted; }

static int inside(const char *path) { return folder[0] && strncmp(path, folder, strlen(folder)) == 0; }

static int of_file(int fd) {
    char link[64], path[4096];
    if (!folder[0]) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(link, path, sizeof path - 1);
    if (n <= 0) return 0;
    path[n] = 0;
    return inside(path);
}

static int of_name(const char *name) {
    char path[8192];
    if (!folder[0]) return 0;
    if (name[0] == '/') return inside(name);
    if (!getcwd(path, 4096)) return 0;
    strcat(path, "/");
    strncat(path, name, 4000);
    return inside(path);
}

static int now(void) { return counted++ == fatal; }
static void end(void) { kill(getpid(), SIGKILL); pause(); }

#define REAL(name) static __typeof__(&name) real; if (!real) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

ssize_t write(int fd, const void *data, size_t n) {
    REAL(write);
    if (of_file(fd) && now()) { if (torn) real(fd, data, n / 2); end(); }
    return real(fd, data, n);
}
ssize_t pwrite(int fd, const void *data, size_t n, off_t at) {
    REAL(pwrite);
    if (of_file(fd) && now()) { if (torn) real(fd, data, n / 2, at); end(); }
    return real(fd, data, n, at);
}
ssize_t pwrite64(int fd, const void *data, size_t n, off64_t at) {
    REAL(pwrite64);
    if (of_file(fd) && now()) { if (torn) real(fd, data, n / 2, at); end(); }
    return real(fd, data, n, at);
}
ssize_t writev(int fd, const struct iovec *data, int n) {
    REAL(writev);
    if (of_file(fd) && now()) end();
    return real(fd, data, n);
}
int ftruncate(int fd, off_t size) {
    REAL(ftruncate);
    if (of_file(fd) && now()) end();
    return real(fd, size);
}
int ftruncate64(int fd, off64_t size) {
    REAL(ftruncate64);
    if (of_file(fd) && now()) end();
    return real(fd, size);
}
int rename(const char *from, const char *to) {
    REAL(rename);
    if (of_name(to) && now()) end();
    return real(from, to);
}
int unlink(const char *name) {
    REAL(unlink);
    if (of_name(name) && now()) end();
    return real(name);
}
int fsync(int fd) {
    REAL(fsync);
    if (of_file(fd) && now()) end();
    return real(fd);
}
static int changes(int flags) { return (flags & (O_CREAT | O_TRUNC)) != 0; }
int open(const char *name, int flags, ...) {
    REAL(open);
    va_list rest;
    va_start(rest, flags);
    mode_t mode = (flags & O_CREAT) ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    if (changes(flags) && of_name(name) && now()) end();
    return real(name, flags, mode);
}
int open64(const char *name, int flags, ...) {
    REAL(open64);
    va_list rest;
    va_start(rest, flags);
    mode_t mode = (flags & O_CREAT) ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    if (changes(flags) && of_name(name) && now()) end();
    return real(name, flags, mode);
}
