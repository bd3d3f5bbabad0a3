// Files of very many tiny items: memory stays within 20 times the file and 256 MiB, the time within seconds,
// and what is too much is refused by one line.
#define _DEFAULT_SOURCE // wait4
#include "test.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "components/components.h"
#include "scene/world.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define IS_SANITIZED true // which takes memory of its own
#else
#define IS_SANITIZED false
#endif

// `count` items between two texts; returns the size of the file.
static uint64_t write_file(const char *path, const char *before, const char *item, unsigned count,
                           const char *after)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fprintf(f, "{\"asset\":{\"version\":\"2.0\"},%s", before);
    for (unsigned i = 0; i < count; i++)
        fprintf(f, "%s%s", i ? "," : "", item);
    fprintf(f, "%s}", after);
    long size = ftell(f);
    assert_int_equal(fclose(f), 0);
    return (uint64_t)size;
}

static ng_result load(const char *path, bool keep)
{
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
    assert_int_equal(ng_world_create(NULL, &world), NG_OK);
    assert_int_equal(ng_components_register(world), NG_OK);
    assert_int_equal(ng_assets_create(&assets), NG_OK);
    ng_result r = ng_gltf_load(path, world, assets, &(struct ng_gltf_params){.keep = keep}, &scene);
    if (r == NG_OK)
        ng_gltf_origin_destroy(&scene.origin);
    ng_world_destroy(&world);
    ng_assets_destroy(&assets);
    return r;
}

// The exit status of a process of its own: 0 where the file loads, 1 where one line refuses it.
static int load_in_child(const char *path, bool keep)
{
    struct test_log log;
    test_log_begin(&log);
    ng_result r = load(path, keep);
    test_log_end(&log);
    return r == NG_OK ? 0 : log.errors == 1 ? 1 : 2;
}

static void check(const char *path, uint64_t size, bool keep)
{
    struct rusage usage;
    int status;
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        _exit(load_in_child(path, keep));
    assert_int_equal(wait4(child, &status, 0, &usage), child);
    uint64_t used = (uint64_t)usage.ru_maxrss << 10, limit = 20 * size + ((uint64_t)256 << 20);
    if (used > limit)
        fprintf(stderr, "%s: %llu MiB, of a limit of %llu\n", path, (unsigned long long)used >> 20,
                (unsigned long long)limit >> 20);
    assert_true(IS_SANITIZED || used <= limit);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) <= 1);
    assert_true(IS_SANITIZED || usage.ru_utime.tv_sec < 15);
}

static void test_memory_follows_the_file(void **state)
{
    static const struct {
        const char *before, *item, *after;
        unsigned count;
    } cases[] = {
        {"\"materials\":[", "{}", "]", 260000},
        {"\"materials\":[", "{}", "]", 1000000},
        {"\"nodes\":[", "{}", "]", 260000},
        {"\"nodes\":[", "[]", "]", 1000000},
        {"\"animations\":[", "{}", "]", 260000},
        {"\"accessors\":[", "{}", "]", 400000},
        {"\"bufferViews\":[", "{}", "]", 400000},
        {"\"buffers\":[", "{}", "]", 400000},
        {"\"images\":[", "{}", "]", 400000},
        {"\"textures\":[", "{}", "]", 400000},
        {"\"samplers\":[", "{}", "]", 400000},
        {"\"cameras\":[", "{}", "]", 400000},
        {"\"skins\":[", "{}", "]", 400000},
        {"\"scenes\":[", "{}", "]", 400000},
        {"\"meshes\":[", "{}", "]", 400000},
        {"\"meshes\":[", "{\"primitives\":[{}]}", "]", 200000},
        {"\"meshes\":[{\"primitives\":[", "{}", "]}]", 400000},
        {"\"meshes\":[{\"primitives\":[{\"targets\":[", "{}", "]}]}]", 400000},
        {"\"animations\":[{\"channels\":[", "{}", "]}]", 400000},
        {"\"animations\":[{\"samplers\":[", "{}", "]}]", 400000},
        {"\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[", "{}", "]}}", 400000},
        {"\"nodes\":[{\"children\":[", "1", "]}]", 2000000},
        {"\"accessors\":[{\"count\":1000000,\"componentType\":5126,\"type\":\"SCALAR\"},{\"count\":1000000,"
         "\"componentType\":5126,\"type\":\"VEC3\"}],\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{}],"
         "\"animations\":[",
         "{\"samplers\":[{\"input\":0,\"output\":1}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"
         "\"path\":\"translation\"}}]}",
         "]", 200},
        {"\"extras\":[", "1", "]", 4000000},
        {"\"extras\":[", "{}", "]", 5000000},
    };
    char path[512];
    NG_UNUSED(state);
    test_path(path, sizeof path, "many.gltf");
    for (size_t i = 0; i < NG_COUNT(cases); i++) {
        uint64_t size = write_file(path, cases[i].before, cases[i].item, cases[i].count, cases[i].after);
        check(path, size, false);
        check(path, size, true);
    }
    remove(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_memory_follows_the_file)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
