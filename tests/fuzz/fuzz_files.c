// Damaged copies of every kind of file that is read. Each is read, or refused with one line and an error;
// nothing crashes, hangs or leaks. A scene that loads is animated and extracted too. Networks have theirs in
// tests/net/test_net_files.c, where their checksum is made right again.
#include "made_files.h"
#include "mutate.h"
#include "readers.h"

#include "asset/exr.h"
#include "asset/image.h"
#include "base/file.h"
#include "base/hash.h"
#include "lightformer/dataset/manifest.h"

// What damage is done to, and who reads it.
struct kind {
    ng_result (*read)(const char *path);
    void (*damage)(struct bytes *b, struct ng_rng *r);
};

// ---- OBJ, MTL and catalogues ----------------------------------------------------------------------------

// The library of a model that is whole.
static ng_result read_library(const char *path)
{
    static const char model[] = "mtllib objects.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl wood\nf 1 2 3\n"
                                "usemtl metal\nf 3 2 1\nusemtl light\nf 2 1 3\n";
    char obj[512];
    snprintf(obj, sizeof obj, "%.*smodel.obj", (int)(ng_path_name(path) - path), path);
    assert_int_equal(ng_file_write(obj, model, sizeof model - 1), NG_OK);
    return fuzz_read_scene(obj);
}

static void write_library(const char *path)
{
    struct bytes b = bytes_read("tests/files/good/objects.mtl");
    assert_int_equal(ng_file_write(path, b.data.items, b.data.count), NG_OK);
    ng_array_finish(&b.data);
}

// A catalogue with these properties, whose checksums are right.
static ng_result read_properties(const char *path)
{
    struct bytes b = bytes_read(path);
    char catalogue[512], piece[520];
    snprintf(catalogue, sizeof catalogue, "%.*smade.sh3f", (int)(ng_path_name(path) - path), path);
    made_catalogue(catalogue, b.data.items, b.data.count);
    ng_array_finish(&b.data);
    snprintf(piece, sizeof piece, "%s#1", catalogue);
    return fuzz_read_scene(piece);
}

// ---- pictures --------------------------------------------------------------------------------------------

static ng_result read_picture(const char *path)
{
    struct bytes b = bytes_read(path);
    struct ng_image image;
    struct ng_image_params params = {.max_memory = 1 << 24};
    ng_result r = ng_image_decode(path, b.data.items, b.data.count, &params, &image);
    if (r == NG_OK)
        ng_image_finish(&image);
    ng_array_finish(&b.data);
    return r;
}

static ng_result read_layers(const char *path)
{
    struct ng_exr exr;
    NG_TRY(ng_exr_read(path, &(struct ng_exr_limits){.max_memory = 1 << 24}, &exr));
    ng_exr_finish(&exr);
    return NG_OK;
}

// ---- checkpoints, manifests ------------------------------------------------------------------------------

// Most are given the checksum of what they hold.
static void damage_checkpoint(struct bytes *b, struct ng_rng *r)
{
    mutate_bytes(b, r);
    if (b->data.count < 8 || fuzz_one_in(r, 8))
        return;
    uint64_t hash = ng_hash_bytes(0, b->data.items, b->data.count - 8);
    memcpy(b->data.items + b->data.count - 8, &hash, sizeof hash);
}

static ng_result read_manifest(const char *path)
{
    char folder[512];
    struct lf_manifest m;
    snprintf(folder, sizeof folder, "%.*s", (int)(ng_path_name(path) - path), path);
    NG_TRY(lf_manifest_read(folder, &m));
    lf_manifest_finish(&m);
    return NG_OK;
}

// ---- rounds ----------------------------------------------------------------------------------------------

static const struct kind text = {fuzz_read_scene, mutate_text}, glb = {fuzz_read_scene, mutate_glb},
                         picture = {read_picture, mutate_bytes}, layers = {read_layers, mutate_bytes},
                         checkpoint = {made_checkpoint_read, damage_checkpoint},
                         manifest = {read_manifest, mutate_text}, library = {read_library, mutate_bytes},
                         properties = {read_properties, mutate_bytes};

// Files to begin with: those of the project, and those that are written first.
static const struct seed {
    const char *file; // its name is that of the copies, as readers go by it
    const struct kind *kind;
    void (*write)(const char *path);
} seeds[] = {
    {"tests/files/good/everything.gltf", &text, NULL},
    {"tests/files/good/skin.gltf", &text, NULL},
    {"tests/files/good/cage.gltf", &text, NULL},
    {"tests/files/good/stage.gltf", &text, NULL},
    {"tests/files/good/triangle.gltf", &text, NULL},
    {"tests/files/geometry/figure.gltf", &text, NULL},
    {"tests/files/geometry/gpu_instancing.gltf", &text, NULL},
    {"tests/files/geometry/draco.gltf", &text, NULL},
    {"tests/files/geometry/meshopt.glb", &glb, NULL},
    {"tests/files/good/objects.obj", &text, NULL},
    {"objects.mtl", &library, write_library},
    {"properties", &properties, made_properties},
    {"content/unit/accessors.glb", &glb, NULL},
    {"content/unit/animated_fields.glb", &glb, NULL},
    {"content/unit/light_mesh.glb", &glb, NULL},
    {"content/unit/subdivision.glb", &glb, NULL},
    {"tests/files/good/grey.jpg", &picture, NULL},
    {"tests/files/good/interlaced.png", &picture, NULL},
    {"content/unit/environment.hdr", &picture, NULL},
    {"picture.exr", &picture, made_exr},
    {"layers.exr", &layers, made_exr},
    {"samples", &checkpoint, made_checkpoint},
    {"manifest.json", &manifest, made_manifest},
};

static void read_seeds(struct bytes out[NG_COUNT(seeds)])
{
    for (size_t i = 0; i < NG_COUNT(seeds); i++) {
        char path[512];
        snprintf(path, sizeof path, "%s", seeds[i].file);
        if (seeds[i].write) {
            test_path(path, sizeof path, seeds[i].file);
            seeds[i].write(path);
        }
        assert_int_equal(seeds[i].kind->read(path), NG_OK);
        out[i] = bytes_read(path);
    }
}

// The damaged file stays where it is if it is judged wrongly.
static bool read_damaged(const struct seed *seed, const struct bytes *b)
{
    char path[512];
    struct test_log log;
    test_path(path, sizeof path, ng_path_name(seed->file));
    assert_int_equal(ng_file_write(path, b->data.items, b->data.count), NG_OK);
    test_log_begin(&log);
    ng_result r = seed->kind->read(path);
    test_log_end(&log);
    if ((r == NG_OK) != (log.errors == 0) || log.errors > 1 || r == NG_ERROR_USAGE)
        fail_msg("%s: result %d with %d errors: %s", path, r, log.errors, log.text);
    return r == NG_OK;
}

static void test_damaged_files(void **state)
{
    NG_UNUSED(state);
    struct bytes originals[NG_COUNT(seeds)];
    uint32_t read = 0;
    read_seeds(originals);
    for (uint32_t round = 0; round < fuzz.rounds; round++) {
        struct ng_rng r = fuzz_round(fuzz.first + round);
        size_t i = ng_rng_below(&r, NG_COUNT(seeds));
        struct bytes b = {0};
        bytes_splice(&b, 0, 0, originals[i].data.items, originals[i].data.count);
        for (uint32_t n = 1 + ng_rng_below(&r, 3); n > 0; n--)
            seeds[i].kind->damage(&b, &r);
        read += read_damaged(&seeds[i], &b);
        ng_array_finish(&b.data);
    }
    for (size_t i = 0; i < NG_COUNT(seeds); i++)
        ng_array_finish(&originals[i].data);
    if (fuzz.rounds > 500) // both are to be tried: what is read, and what is refused
        assert_true(read > fuzz.rounds / 10 && read < fuzz.rounds * 9 / 10);
}

int main(int argc, char **argv)
{
    fuzz_arguments(argc, argv);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_damaged_files)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
