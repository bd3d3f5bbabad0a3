// A scene of several files is replaced as a whole: killed before any of the calls that write, or with a disk
// that fails in any of them, the old scene is there or the new one, never a mixture.
// CMakeLists.txt has the linker put our write, fsync and renameat in the place of the system's.
#define _POSIX_C_SOURCE 200809L // fork
#include "scene_equal.h"

#include "asset/gltf_save.h"
#include "base/file.h"

#include <errno.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

// ---- Faults ----------------------------------------------------------------------------------------------

static struct {
    unsigned countdown; // the call of this number from now has a fault; 0: none
    bool kill;          // it ends the process; else the disk is full
} fault;

static bool is_due(void)
{
    return fault.countdown && --fault.countdown == 0;
}

static int suffer(void)
{
    if (fault.kill)
        raise(SIGKILL);
    errno = ENOSPC;
    return -1;
}

ssize_t __real_write(int fd, const void *data, size_t size);
ssize_t __wrap_write(int fd, const void *data, size_t size);
int __real_fsync(int fd);
int __wrap_fsync(int fd);
int __real_renameat(int from, const char *name, int to, const char *new_name);
int __wrap_renameat(int from, const char *name, int to, const char *new_name);

ssize_t __wrap_write(int fd, const void *data, size_t size)
{
    if (!is_due())
        return __real_write(fd, data, size);
    if (__real_write(fd, data, size / 2) < 0) // a part of it arrives
        return -1;
    return suffer();
}

int __wrap_fsync(int fd)
{
    return is_due() ? suffer() : __real_fsync(fd);
}

int __wrap_renameat(int from, const char *name, int to, const char *new_name)
{
    return is_due() ? suffer() : __real_renameat(from, name, to, new_name);
}

// ---- Sets of files ---------------------------------------------------------------------------------------

static void place(char out[512], const char *folder, const char *name)
{
    test_path(out, 512, folder);
    assert_int_equal(ng_file_make_directory(out), NG_OK);
    size_t n = strlen(out);
    snprintf(out + n, 512 - n, "/%s", name);
}

static void copy(const char *from, const char *folder, const char *name)
{
    char to[512];
    void *data;
    size_t size;
    place(to, folder, name);
    assert_int_equal(ng_file_read(from, 0, &data, &size), NG_OK);
    assert_int_equal(ng_file_write(to, data, size), NG_OK);
    free(data);
}

static void empty(const char *folder)
{
    char path[512], command[600];
    test_path(path, sizeof path, folder);
    snprintf(command, sizeof command, "rm -rf '%s'", path);
    assert_int_equal(system(command), 0);
}

static void count_file(void *user, const char *name)
{
    if (name[0] != '.')
        ++*(unsigned *)user;
}

static unsigned files_in(const char *folder)
{
    char path[512];
    unsigned count = 0;
    test_path(path, sizeof path, folder);
    assert_int_equal(ng_file_list(path, count_file, &count), NG_OK);
    return count;
}

static void load(struct scene *s, const char *path)
{
    struct test_log log;
    test_log_begin(&log);
    ng_result r = scene_load(s, path, true);
    test_log_end(&log);
    if (r != NG_OK)
        fail_msg("%s was not loaded: %s", path, log.text);
}

static ng_result save(const struct scene *s, const char *path)
{
    const struct ng_gltf_save_params params = {s->world, s->assets, s->loaded.root, s->loaded.origin};
    return ng_gltf_save(path, &params);
}

// Whether the document and all that it names are those of a scene.
static bool holds_scene(const char *path, struct scene *want)
{
    struct scene got;
    char why[256];
    load(&got, path);
    bool same = scene_equal(&got, want, why, sizeof why);
    scene_finish(&got);
    return same;
}

// ---- Every moment ----------------------------------------------------------------------------------------

struct scenes {
    const char *out; // "scene.gltf"
    struct scene old, new;
};

// How a child ended that saved with a fault: 0: it came to an end before the fault.
static int save_with_fault(const struct scene *s, const char *path, unsigned call, bool kills)
{
    int status;
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct test_log log;
        test_log_begin(&log);
        fault.countdown = call;
        fault.kill = kills;
        bool good = save(s, path) == NG_OK;
        _exit(good ? 0 : log.errors == 1 && strstr(log.text, "No space left") ? 1 : 2);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status);
}

// Gives the number of moments.
static unsigned try_every_moment(struct scenes *s, bool kills)
{
    char path[512];
    for (unsigned call = 1;; call++) {
        empty("out");
        place(path, "out", s->out);
        assert_int_equal(save(&s->old, path), NG_OK);
        unsigned before = files_in("out");
        int end = save_with_fault(&s->new, path, call, kills);
        bool is_new = holds_scene(path, &s->new);
        if (!is_new && !holds_scene(path, &s->old))
            fail_msg("%s, call %u: neither the old scene nor the new one", s->out, call);
        if (end == 0) {
            assert_true(is_new);
            return call - 1;
        }
        assert_int_equal(end, kills ? SIGKILL : 1);
        if (!kills && !is_new) // nothing is left of what did not succeed
            assert_int_equal(files_in("out"), before);
        assert_int_equal(save_with_fault(&s->new, path, 0, false), 0); // and the next try succeeds
        assert_true(holds_scene(path, &s->new));
    }
}

static void check(const char *old, const char *new, const char *out)
{
    struct scenes s = {.out = out};
    load(&s.old, old);
    load(&s.new, new);
    char why[256];
    assert_false(scene_equal(&s.old, &s.new, why, sizeof why));
    unsigned killed = try_every_moment(&s, true), failed = try_every_moment(&s, false);
    print_message("%s: %u moments\n", out, killed);
    assert_int_equal(killed, failed);
    assert_true(killed >= 8); // two files, each of them written, flushed, renamed, its folder flushed
    scene_finish(&s.old);
    scene_finish(&s.new);
}

// A document, a buffer and a picture, of which all three differ.
static void buffers_and_textures_beside(void **state)
{
    NG_UNUSED(state);
    char path[512];
    void *data;
    size_t size;
    copy("tests/files/saving/foreign.gltf", "other", "foreign.gltf");
    copy("tests/files/good/interlaced.png", "other", "picture.png");
    place(path, "other", "data.bin");
    assert_int_equal(ng_file_read("tests/files/saving/data.bin", 0, &data, &size), NG_OK);
    ((unsigned char *)data)[0] ^= 1; // the last bit of a number
    assert_int_equal(ng_file_write(path, data, size), NG_OK);
    free(data);
    place(path, "other", "foreign.gltf");
    check("tests/files/saving/foreign.gltf", path, "scene.gltf");
    check(path, "tests/files/saving/foreign.gltf", "foreign.gltf");
}

// What glTF has no place for is beside a .glb, too.
static void a_sky_beside(void **state)
{
    NG_UNUSED(state);
    char path[512];
    void *data;
    size_t size;
    copy("content/unit/light_environment.glb", "sky", "light_environment.glb");
    place(path, "sky", "environment.hdr");
    assert_int_equal(ng_file_read("content/unit/environment.hdr", 0, &data, &size), NG_OK);
    ((unsigned char *)data)[size - 1] ^= 1; // of an exponent
    assert_int_equal(ng_file_write(path, data, size), NG_OK);
    free(data);
    place(path, "sky", "light_environment.glb");
    check("content/unit/light_environment.glb", path, "scene.glb");
    check("content/unit/light_environment.glb", path, "scene.gltf");
}

// From a scene in one file to one in many, and back.
static void another_scene_under_the_same_name(void **state)
{
    NG_UNUSED(state);
    check("content/unit/textures.glb", "tests/files/saving/foreign.gltf", "scene.gltf");
    check("tests/files/saving/foreign.gltf", "content/unit/textures.glb", "scene.gltf");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(buffers_and_textures_beside),
        cmocka_unit_test(a_sky_beside),
        cmocka_unit_test(another_scene_under_the_same_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
