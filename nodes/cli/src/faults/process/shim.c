/* Preloaded into the nodes of a trial (LD_PRELOAD): puts their wall clock and the recorder's disk into the hand of
 * `fdm faults --process`, which writes to the file named by FDM_SHIM. A slow or full disk and a clock that is set are
 * then what the programs see, without privileges. The monotonic clock is left alone, as the system leaves it. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

struct control {
    _Atomic int64_t wall_ns;  /* added to CLOCK_REALTIME */
    _Atomic int64_t delay_ns; /* time that each write and sync of the recorder takes */
    _Atomic int64_t error;    /* not 0: what the recorder's disk answers, an errno */
};

static struct control *control;
static int records;

__attribute__((constructor)) static void start(void) {
    const char *path = getenv("FDM_SHIM");
    int file = path ? open(path, O_RDWR | O_CLOEXEC) : -1;
    if (file < 0) return;
    void *mapped = mmap(NULL, sizeof *control, PROT_READ, MAP_SHARED, file, 0);
    close(file);
    records = strcmp(program_invocation_short_name, "bag_recorder") == 0;
    if (mapped != MAP_FAILED) control = mapped;
}

int clock_gettime(clockid_t id, struct timespec *now) {
    if (syscall(SYS_clock_gettime, id, now) != 0) return -1;
    if (control && id == CLOCK_REALTIME) {
        int64_t ns = now->tv_sec * 1000000000LL + now->tv_nsec + control->wall_ns;
        now->tv_sec = ns / 1000000000LL;
        now->tv_nsec = ns % 1000000000LL;
    }
    return 0;
}

/* Whether the file lies on the recorder's disk: its log does not. */
static int on_disk(int file) {
    struct stat status;
    return control && records && file > STDERR_FILENO && fstat(file, &status) == 0 && S_ISREG(status.st_mode);
}

static void take_time(void) {
    int64_t ns = control->delay_ns;
    struct timespec pause = {ns / 1000000000LL, ns % 1000000000LL};
    if (ns > 0) nanosleep(&pause, NULL);
}

ssize_t write(int file, const void *bytes, size_t count) {
    if (on_disk(file)) {
        take_time();
        if (control->error) {
            errno = (int)control->error;
            return -1;
        }
    }
    return syscall(SYS_write, file, bytes, count);
}

/* A full disk takes no more, but keeps what it has; a broken one does not. */
static int fails(int file) {
    if (!on_disk(file)) return 0;
    take_time();
    if (control->error != EIO) return 0;
    errno = EIO;
    return -1;
}

int fdatasync(int file) {
    if (fails(file)) return -1;
    return syscall(SYS_fdatasync, file);
}

int fsync(int file) {
    if (fails(file)) return -1;
    return syscall(SYS_fsync, file);
}
