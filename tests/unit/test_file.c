// Files: what is there and what is written, and what is left when something goes wrong in between.
// CMakeLists.txt has the linker put our write, fsync and renameat in the place of the system's.
#define _POSIX_C_SOURCE 200809L // symlink, fork
#include "test.h"

#include "base/file.h"
#include "base/interrupt.h"
#include "base/log.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

// ---- faults ----------------------------------------------------------------------------------------------

// What the next calls do instead: fail with an error, or have a signal sent first. 0: nothing special.
static struct {
    int write, fsync, renameat; // errno
    int signal;                 // at the next fsync
} fault;

ssize_t __real_write(int fd, const void *data, size_t size);
ssize_t __wrap_write(int fd, const void *data, size_t size);
int __real_fsync(int fd);
int __wrap_fsync(int fd);
int __real_renameat(int from, const char *name, int to, const char *new_name);
int __wrap_renameat(int from, const char *name, int to, const char *new_name);

// A disk that is full takes a part first.
ssize_t __wrap_write(int fd, const void *data, size_t size)
{
    if (!fault.write || size == 1)
        return __real_write(fd, data, size);
    errno = fault.write;
    return size > 8 ? __real_write(fd, data, size / 2) : -1;
}

int __wrap_fsync(int fd)
{
    int number = fault.signal;
    fault.signal = 0;
    if (number)
        raise(number);
    errno = fault.fsync;
    return fault.fsync ? -1 : __real_fsync(fd);
}

int __wrap_renameat(int from, const char *name, int to, const char *new_name)
{
    errno = fault.renameat;
    return fault.renameat ? -1 : __real_renameat(from, name, to, new_name);
}

// ---- helpers ---------------------------------------------------------------------------------------------

// Makes a folder of this name, empty, and gives the path of a file in it.
static void fresh(const char *folder, const char *name, char *out, size_t size)
{
    char path[512], command[600];
    test_path(path, sizeof path, folder);
    snprintf(command, sizeof command, "rm -rf '%s'", path);
    assert_int_equal(system(command), 0);
    assert_int_equal(ng_file_make_directory(path), NG_OK);
    assert_true((size_t)snprintf(out, size, "%s/%s", path, name) < size);
}

static void put(const char *path, const char *text)
{
    assert_int_equal(ng_file_write(path, text, strlen(text)), NG_OK);
}

static void assert_holds(const char *path, const char *text)
{
    void *data;
    size_t size;
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    assert_string_equal(data, text);
    free(data);
}

static mode_t mode_of(const char *path)
{
    struct stat status;
    assert_int_equal(lstat(path, &status), 0);
    return status.st_mode;
}

static void count_file(void *user, const char *name)
{
    *(int *)user += name[0] != '.';
}

// How many files are in the folder of `beside`.
static int files_beside(const char *beside)
{
    char folder[PATH_MAX];
    int count = 0;
    assert_true(ng_path_beside(beside, ".", folder, sizeof folder));
    assert_int_equal(ng_file_list(folder, count_file, &count), NG_OK);
    return count;
}

// One line that names the file.
static void assert_refused(const char *path, ng_result as)
{
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(ng_file_write(path, "new", 3), as);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, path));
    test_log_end(&log);
}

// ---- writing ---------------------------------------------------------------------------------------------

static void file_write_is_atomic_and_errors_name_the_file(void **state)
{
    NG_UNUSED(state);
    char path[512];
    test_path(path, sizeof path, "a.bin");
    assert_int_equal(ng_file_write(path, "hello", 5), NG_OK);
    void *data;
    size_t size;
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    assert_int_equal(size, 5);
    assert_memory_equal(data, "hello", 6);
    free(data);

    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(ng_file_read(path, 4, &data, &size), NG_ERROR_MEMORY);
    assert_non_null(strstr(log.text, "a.bin"));
    assert_int_equal(ng_file_read("/no/such/file", 0, &data, &size), NG_ERROR_NOT_FOUND);
    assert_non_null(strstr(log.text, "/no/such/file"));
    assert_int_equal(ng_file_read(".", 0, &data, &size), NG_ERROR_IO);
    assert_int_equal(ng_file_write("/dev/full/x", "x", 1), NG_ERROR_IO);
    assert_int_equal(ng_file_write("/no/such/dir/x", "x", 1), NG_ERROR_NOT_FOUND);
    test_log_end(&log);
    assert_int_equal(log.errors, 5);
}

static void what_cannot_be_written_is_known_before(void **state)
{
    NG_UNUSED(state);
    char path[512], link[512];
    test_path(path, sizeof path, "b.bin");
    test_path(link, sizeof link, "b.link");
    remove(path);
    remove(link);
    assert_int_equal(ng_file_check_writable(path), NG_OK);
    assert_false(ng_file_exists(path));
    assert_int_equal(ng_file_write(path, "hello", 5), NG_OK);
    assert_int_equal(ng_file_check_writable(path), NG_OK);
    assert_int_equal(symlink("b.bin", link), 0);
    assert_int_equal(ng_file_check_writable(link), NG_OK);
    assert_int_equal(ng_file_check_writable("here.bin"), NG_OK);
    assert_int_equal(ng_file_check_writable("/dev/null"), NG_OK);

    static const struct {
        const char *path;
        ng_result as;
    } bad[] = {{".", NG_ERROR_IO}, {"/no/such/dir/x", NG_ERROR_NOT_FOUND}, {"/dev/full/x", NG_ERROR_IO}};
    struct test_log log;
    for (size_t i = 0; i < NG_COUNT(bad); i++) {
        test_log_begin(&log);
        assert_int_equal(ng_file_check_writable(bad[i].path), bad[i].as);
        assert_int_equal(log.errors, 1);
        assert_non_null(strstr(log.text, bad[i].path));
        test_log_end(&log);
    }
}

static void one_file_has_many_paths(void **state)
{
    NG_UNUSED(state);
    char path[512], other[512], detour[512], link[512];
    test_path(path, sizeof path, "same.bin");
    test_path(detour, sizeof detour, "./same.bin");
    test_path(other, sizeof other, "other.bin");
    test_path(link, sizeof link, "same.link");
    remove(path);
    remove(other);
    remove(link);
    assert_true(ng_file_same(path, detour)); // also where nothing is yet
    assert_false(ng_file_same(path, other));
    assert_int_equal(ng_file_write(path, "hello", 5), NG_OK);
    assert_int_equal(symlink("same.bin", link), 0);
    assert_true(ng_file_same(path, detour));
    assert_true(ng_file_same(path, link));
    assert_false(ng_file_same(path, other));
    assert_false(ng_file_same(link, other));
    assert_int_equal(linkat(AT_FDCWD, path, AT_FDCWD, other, 0), 0); // a hard link
    assert_true(ng_file_same(link, other));
    remove(path);
    assert_true(ng_file_same(path, link)); // what would be made is the same
    assert_false(ng_file_same("/dev/null", "/dev/null"));
    assert_false(ng_file_same("/no/such/folder/x", "/no/such/folder/x"));
}

static void count_name(void *user, const char *name)
{
    *(int *)user += strcmp(name, "listed.bin") == 0;
}

static void folders_are_listed(void **state)
{
    NG_UNUSED(state);
    char path[512], folder[512];
    struct test_log log;
    int found = 0;
    test_path(path, sizeof path, "listed.bin");
    assert_true(ng_path_beside(path, ".", folder, sizeof folder));
    assert_int_equal(ng_file_write(path, "hello", 5), NG_OK);
    assert_int_equal(ng_file_list(folder, count_name, &found), NG_OK);
    assert_int_equal(found, 1);
    test_log_begin(&log);
    assert_int_equal(ng_file_list(path, count_name, &found), NG_ERROR_IO);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
}

static void paths(void **state)
{
    NG_UNUSED(state);
    char out[16];
    assert_true(ng_path_beside("a/b.gltf", "c.bin", out, sizeof out));
    assert_string_equal(out, "a/c.bin");
    assert_true(ng_path_beside("b.gltf", "c.bin", out, sizeof out));
    assert_string_equal(out, "c.bin");
    assert_true(ng_path_beside("a/b.gltf", "/c.bin", out, sizeof out));
    assert_string_equal(out, "/c.bin");
    assert_false(ng_path_beside("a/b.gltf", "a-rather-long-name", out, sizeof out));
    assert_string_equal(ng_path_extension("a.b/c"), "");
    assert_string_equal(ng_path_extension("a/b.x.exr"), "exr");
    assert_string_equal(ng_path_extension("a/.hidden"), "");
}

static void what_is_replaced_keeps_mode_and_owner(void **state)
{
    NG_UNUSED(state);
    static const mode_t modes[] = {0600, 0640, 0644, 0666, 0755};
    char path[512];
    fresh("mode", "a", path, sizeof path);
    mode_t mask = umask(027);
    put(path, "new");
    assert_int_equal(mode_of(path) & 07777, 0640);
    for (size_t i = 0; i < NG_COUNT(modes); i++) {
        assert_int_equal(chmod(path, modes[i]), 0);
        put(path, "again");
        assert_int_equal(mode_of(path) & 07777, modes[i]);
    }
    assert_int_equal(chmod(path, 06755), 0); // that a program is another user's does not follow from its name
    put(path, "other bytes");
    assert_int_equal(mode_of(path) & 07777, 0755);
    umask(mask);
    struct stat status;
    if (geteuid() != 0)
        return;
    assert_int_equal(chown(path, 12345, 23456), 0);
    put(path, "theirs");
    assert_int_equal(stat(path, &status), 0);
    assert_int_equal(status.st_uid, 12345);
    assert_int_equal(status.st_gid, 23456);
}

static void what_is_read_only_stays(void **state)
{
    NG_UNUSED(state);
    struct test_log log;
    char path[512];
    fresh("read_only", "a", path, sizeof path);
    put(path, "old");
    assert_int_equal(chmod(path, 0444), 0); // for root too
    assert_refused(path, NG_ERROR_IO);
    test_log_begin(&log);
    assert_int_equal(ng_file_check_writable(path), NG_ERROR_IO);
    test_log_end(&log);
    assert_holds(path, "old");
    assert_int_equal(files_beside(path), 1);
}

static void links_stay_links(void **state)
{
    NG_UNUSED(state);
    char path[512], link[512], second[512], nowhere[512];
    fresh("links", "a", path, sizeof path);
    test_path(link, sizeof link, "links/link");
    test_path(second, sizeof second, "links/second");
    test_path(nowhere, sizeof nowhere, "links/nowhere");
    assert_int_equal(symlink("../links/a", link), 0);
    assert_int_equal(symlink("link", second), 0);
    put(second, "made"); // where nothing was
    assert_holds(path, "made");
    put(second, "replaced");
    assert_holds(path, "replaced");
    assert_true(S_ISLNK(mode_of(link)) && S_ISLNK(mode_of(second)));

    assert_int_equal(symlink("none/x", nowhere), 0);
    assert_refused(nowhere, NG_ERROR_NOT_FOUND);
    assert_true(S_ISLNK(mode_of(nowhere)));
    assert_int_equal(unlink(nowhere), 0);
    assert_int_equal(symlink("nowhere", nowhere), 0); // to itself
    assert_refused(nowhere, NG_ERROR_IO);
    assert_int_equal(files_beside(path), 4);
}

static void names_may_be_as_long_as_names_are(void **state)
{
    NG_UNUSED(state);
    char name[NAME_MAX + 2] = {0}, path[1024];
    memset(name, 'n', NAME_MAX);
    fresh("long", name, path, sizeof path);
    put(path, "long");
    assert_holds(path, "long");
    memset(name, 'n', NAME_MAX + 1);
    fresh("long", name, path, sizeof path);
    assert_refused(path, NG_ERROR_IO);
    assert_int_equal(files_beside(path), 0);
}

static void a_failure_leaves_the_old_file_alone(void **state)
{
    NG_UNUSED(state);
    char path[512];
    fresh("faults", "a", path, sizeof path);
    put(path, "old");
    const struct {
        int *call, number;
    } faults[] = {
        {&fault.write, ENOSPC}, {&fault.write, EDQUOT}, {&fault.write, EIO},    {&fault.write, EFBIG},
        {&fault.fsync, EIO},    {&fault.fsync, ENOSPC}, {&fault.renameat, EIO},
    };
    for (size_t i = 0; i < NG_COUNT(faults); i++) {
        struct test_log log;
        test_log_begin(&log);
        *faults[i].call = faults[i].number;
        assert_int_equal(ng_file_write(path, "many new bytes", 14), NG_ERROR_IO);
        *faults[i].call = 0;
        assert_int_equal(log.errors, 1);
        assert_non_null(strstr(log.text, path));
        assert_non_null(strstr(log.text, strerror(faults[i].number)));
        test_log_end(&log);
        assert_holds(path, "old");
        assert_int_equal(files_beside(path), 1);
    }
    fault.fsync = EINVAL; // of file systems without
    put(path, "new");
    fault.fsync = 0;
    assert_holds(path, "new");
}

static void streams_are_written_to(void **state)
{
    NG_UNUSED(state);
    char pipe_path[512], path[512], text[16] = {0};
    fresh("streams", "pipe", pipe_path, sizeof pipe_path);
    test_path(path, sizeof path, "streams/a");
    assert_int_equal(mkfifo(pipe_path, 0600), 0);
    int reader = open(pipe_path, O_RDONLY | O_NONBLOCK);
    put(pipe_path, "piped");
    assert_int_equal(read(reader, text, sizeof text), 5);
    assert_string_equal(text, "piped");
    close(reader);
    put("/dev/null", "nothing");

    // What went to a descriptor before stays before.
    char name[64];
    int fd = open(path, O_WRONLY | O_CREAT, 0600);
    assert_int_equal(write(fd, "a", 1), 1);
    snprintf(name, sizeof name, "/dev/fd/%d", fd);
    put(name, "b");
    assert_int_equal(write(fd, "c", 1), 1);
    assert_true(ng_file_same(name, path));
    close(fd);
    assert_holds(path, "abc");
    assert_refused(name, NG_ERROR_IO); // closed
}

// ---- signals ---------------------------------------------------------------------------------------------

// Runs a child that writes while a signal comes; how it ended.
static int write_while(const char *path, int number, bool hold)
{
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        ng_interrupt_watch();
        if (hold)
            ng_interrupt_hold();
        fault.signal = number;
        bool good = ng_file_write(path, "new", 3) == NG_OK;
        if (good && ng_interrupt_came())
            ng_interrupt_release();
        _exit(1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

static void a_signal_leaves_one_of_both_files_and_nothing_else(void **state)
{
    NG_UNUSED(state);
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    char path[512];
    fresh("signals", "a", path, sizeof path);
    for (size_t i = 0; i < NG_COUNT(numbers); i++) {
        put(path, "old");
        assert_int_equal(write_while(path, numbers[i], false), numbers[i]);
        assert_holds(path, "old");
        assert_int_equal(files_beside(path), 1);
        assert_int_equal(write_while(path, numbers[i], true), numbers[i]);
        assert_holds(path, "new");
        assert_int_equal(files_beside(path), 1);
    }
}

static void touch_beside(const char *path, const char *name)
{
    char other[1024];
    assert_true(ng_path_beside(path, name, other, sizeof other));
    put(other, "");
}

// Nothing can be done at SIGKILL; so what it leaves goes with the next that writes the same file.
static void what_was_left_by_the_killed_is_removed(void **state)
{
    NG_UNUSED(state);
    char path[512];
    fresh("killed", "a.glb", path, sizeof path);
    put(path, "old");
    for (int i = 0; i < 3; i++)
        assert_int_equal(write_while(path, SIGKILL, false), SIGKILL);
    assert_holds(path, "old");
    assert_int_equal(files_beside(path), 2); // each has removed that of the one before
    static const char *const others[] = {"b.glb.tmp-0123456789abcdef",  "a.glb.tmp-0123456789abcdef0",
                                         "a.glb.tmp-0123456789abcdeg",  "a.glb.tmp-",
                                         "a.glbs.tmp-0123456789abcdef", "a.glb.tmp_0123456789abcdef"};
    for (size_t i = 0; i < NG_COUNT(others); i++)
        touch_beside(path, others[i]);
    put(path, "new");
    assert_holds(path, "new");
    assert_int_equal(files_beside(path), 1 + (int)NG_COUNT(others));
}

// Who lives may be slow.
static void what_another_process_is_making_stays(void **state)
{
    NG_UNUSED(state);
    char path[512];
    int status;
    fresh("slow", "a", path, sizeof path);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        fault.signal = SIGSTOP;
        _exit(ng_file_write(path, "slow", 4) == NG_OK ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &status, WUNTRACED), child);
    assert_true(WIFSTOPPED(status));
    put(path, "quick");
    assert_int_equal(files_beside(path), 2);
    assert_int_equal(kill(child, SIGCONT), 0);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    assert_holds(path, "slow");
    assert_int_equal(files_beside(path), 1);
}

// Many at once, of which each looks for what others have left.
static void many_processes_may_write_one_file(void **state)
{
    NG_UNUSED(state);
    enum { PROCESSES = 4, TIMES = 100 };
    char path[512];
    int status;
    fresh("many", "a", path, sizeof path);
    for (int i = 0; i < PROCESSES; i++) {
        pid_t child = fork();
        assert_true(child >= 0);
        if (child)
            continue;
        bool good = true;
        for (int k = 0; k < TIMES; k++)
            good = ng_file_write(path, "whole", 5) == NG_OK && good;
        _exit(good ? 0 : 1);
    }
    for (int i = 0; i < PROCESSES; i++) {
        assert_true(waitpid(-1, &status, 0) > 0);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    }
    assert_holds(path, "whole");
    assert_int_equal(files_beside(path), 1);
}

static void an_ignored_signal_stays_ignored(void **state)
{
    NG_UNUSED(state);
    char path[512];
    fresh("nohup", "a", path, sizeof path);
    signal(SIGHUP, SIG_IGN);
    assert_int_equal(write_while(path, SIGHUP, false), 0);
    signal(SIGHUP, SIG_DFL);
    assert_holds(path, "new");
}

// ---- places ----------------------------------------------------------------------------------------------

static void a_link_may_lead_out_of_a_folder(void **state)
{
    NG_UNUSED(state);
    char scene[512], in[512], out[512], beside[512];
    fresh("outside", "in", in, sizeof in);
    fresh("below", "scene.gltf", scene, sizeof scene);
    put(in, "secret");
    test_path(out, sizeof out, "below/out");
    test_path(beside, sizeof beside, "below/beside");
    assert_int_equal(symlink("../outside/in", out), 0);
    assert_int_equal(symlink("scene.gltf", beside), 0);
    assert_true(ng_file_is_below(beside, scene)); // where nothing is
    put(scene, "{}");
    assert_true(ng_file_is_below(beside, scene));
    assert_true(ng_file_is_below(scene, scene));
    assert_false(ng_file_is_below(out, scene));
    assert_false(ng_file_is_below(in, scene));
    // A folder is not in another whose name it begins with.
    char longer[512];
    fresh("below2", "in", longer, sizeof longer);
    put(longer, "x");
    assert_false(ng_file_is_below(longer, scene));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(file_write_is_atomic_and_errors_name_the_file),
        cmocka_unit_test(what_cannot_be_written_is_known_before),
        cmocka_unit_test(what_is_replaced_keeps_mode_and_owner),
        cmocka_unit_test(what_is_read_only_stays),
        cmocka_unit_test(links_stay_links),
        cmocka_unit_test(names_may_be_as_long_as_names_are),
        cmocka_unit_test(a_failure_leaves_the_old_file_alone),
        cmocka_unit_test(streams_are_written_to),
        cmocka_unit_test(a_signal_leaves_one_of_both_files_and_nothing_else),
        cmocka_unit_test(what_was_left_by_the_killed_is_removed),
        cmocka_unit_test(what_another_process_is_making_stays),
        cmocka_unit_test(many_processes_may_write_one_file),
        cmocka_unit_test(an_ignored_signal_stays_ignored),
        cmocka_unit_test(one_file_has_many_paths),
        cmocka_unit_test(a_link_may_lead_out_of_a_folder),
        cmocka_unit_test(folders_are_listed),
        cmocka_unit_test(paths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
