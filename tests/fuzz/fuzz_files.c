// Damaged copies of every kind of file that is read. Each is read, or refused with one line and an error;
// nothing crashes, hangs or leaks. A scene that loads is animated and extracted too. Networks have theirs in
// tests/net/test_net_files.c, where their checksum is made right again.
#include "mutate.h"

#include "asset/assets.h"
#include "asset/exr.h"
#include "asset/gltf.h"
#include "asset/image.h"
#include "base/file.h"
#include "base/hash.h"
#include "components/components.h"
#include "lightformer/dataset/manifest.h"
#include "lightformer/dataset/variations.h"
#include "lightformer/reference/reference_internal.h"
#include "render/extract.h"
#include "render/scene_systems.h"
#include "scene/system.h"
#include "scene/world.h"

#include <zip.h>

// What damage is done to, and who reads it.
struct kind {
    ng_result (*read)(const char *path);
    void (*damage)(struct bytes *b, struct ng_rng *r);
};

static struct bytes read_file(const char *path)
{
    struct bytes b = {0};
    void *data;
    size_t size;
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    bytes_splice(&b, 0, 0, data, size);
    free(data);
    return b;
}

// ---- scenes ----------------------------------------------------------------------------------------------

// Animated to some times, also beyond all keys, and extracted at each.
static ng_result extract(struct ng_world *world, struct ng_assets *assets)
{
    static const double times[] = {0, 0.3, 1e9};
    struct ng_extractor *extractor;
    NG_TRY(ng_scene_systems_add(world, assets, NULL));
    NG_TRY(ng_extractor_create(&extractor));
    ng_result r = NG_OK;
    for (size_t i = 0; i < NG_COUNT(times) && r == NG_OK; i++) {
        const struct ng_snapshot *snapshot;
        r = ng_world_run(world, times[i]);
        if (r == NG_OK)
            r = ng_extract(extractor,
                           &(struct ng_extract_params){.world = world, .assets = assets, .time = times[i]},
                           &snapshot);
    }
    ng_extractor_destroy(&extractor);
    return r;
}

static ng_result use_scene(struct ng_world *world, struct ng_assets *assets,
                           const struct ng_gltf_scene *scene)
{
    struct lf_variations *variations;
    if (scene->triangle_count > 2000) // what takes long under a sanitizer is the refining
        return NG_OK;
    NG_TRY(extract(world, assets));
    ng_result r = lf_variations_create(world, &variations);
    lf_variations_destroy(&variations);
    return r;
}

static ng_result read_scene(const char *path)
{
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
    assert_int_equal(ng_world_create(NULL, &world), NG_OK);
    assert_int_equal(ng_components_register(world), NG_OK);
    assert_int_equal(ng_assets_create(&assets), NG_OK);
    ng_result r = ng_gltf_load(path, world, assets, &(struct ng_gltf_params){.max_memory = 1 << 23}, &scene);
    if (r == NG_OK) {
        r = use_scene(world, assets, &scene);
    } else {
        assert_int_equal(ng_world_entity_count(world), 0);
        assert_int_equal(ng_assets_memory(assets), 0);
    }
    ng_world_destroy(&world);
    ng_assets_destroy(&assets);
    return r;
}

static void damage_text(struct bytes *b, struct ng_rng *r)
{
    size_t end = b->data.count;
    if (fuzz_one_in(r, 6))
        mutate_bytes(b, r);
    else
        mutate_json(b, 0, &end, r);
}

static uint32_t word_at(const struct bytes *b, size_t at)
{
    uint32_t value = 0;
    for (size_t i = 0; i < 4 && at + i < b->data.count; i++)
        value |= (uint32_t)b->data.items[at + i] << (8 * i);
    return value;
}

static void put_word(struct bytes *b, size_t at, size_t value)
{
    for (size_t i = 0; i < 4 && at + i < b->data.count; i++)
        b->data.items[at + i] = (unsigned char)(value >> (8 * i));
}

// The JSON chunk, with lengths that are right again, or the file as bytes.
static void damage_glb(struct bytes *b, struct ng_rng *r)
{
    size_t json = word_at(b, 12), end = 20 + json;
    if (end > b->data.count || fuzz_one_in(r, 3)) {
        mutate_bytes(b, r);
        return;
    }
    mutate_json(b, 20, &end, r);
    while (end < b->data.count && end % 4 != 0)
        bytes_splice(b, end++, 0, " ", 1);
    put_word(b, 12, end - 20);
    put_word(b, 8, b->data.count);
}

// ---- OBJ, MTL and catalogues ----------------------------------------------------------------------------

// The library of a model that is whole.
static ng_result read_library(const char *path)
{
    static const char model[] = "mtllib objects.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl wood\nf 1 2 3\n"
                                "usemtl metal\nf 3 2 1\nusemtl light\nf 2 1 3\n";
    char obj[512];
    snprintf(obj, sizeof obj, "%.*smodel.obj", (int)(ng_path_name(path) - path), path);
    assert_int_equal(ng_file_write(obj, model, sizeof model - 1), NG_OK);
    return read_scene(obj);
}

static void write_library(const char *path)
{
    struct bytes b = read_file("tests/files/good/objects.mtl");
    assert_int_equal(ng_file_write(path, b.data.items, b.data.count), NG_OK);
    ng_array_finish(&b.data);
}

static void write_properties(const char *path)
{
    static const char text[] =
        "name=Things\nlicense=CC-BY \\u00e9\nid#1=T#box\nname#1=A box\nmodel#1=/m/box.obj\n"
        "width#1=100\ndepth#1=50.5\nheight#1=20\nmodelRotation#1=0 0 1 0 1 0 -1 0 0\n"
        "creator#1=\\\n  Ann\nmovable#1=true\n";
    assert_int_equal(ng_file_write(path, text, sizeof text - 1), NG_OK);
}

// A catalogue with these properties, whose checksums are right.
static ng_result read_properties(const char *path)
{
    static const char box[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";
    struct bytes b = read_file(path);
    char catalogue[512], piece[520];
    snprintf(catalogue, sizeof catalogue, "%.*smade.sh3f", (int)(ng_path_name(path) - path), path);
    zip_t *zip = zip_open(catalogue, ZIP_CREATE | ZIP_TRUNCATE, NULL);
    assert_non_null(zip);
    assert_true(zip_file_add(zip, "PluginFurnitureCatalog.properties",
                             zip_source_buffer(zip, b.data.items, b.data.count, 0), 0) >= 0);
    assert_true(zip_file_add(zip, "m/box.obj", zip_source_buffer(zip, box, sizeof box - 1, 0), 0) >= 0);
    assert_int_equal(zip_close(zip), 0);
    ng_array_finish(&b.data);
    snprintf(piece, sizeof piece, "%s#1", catalogue);
    return read_scene(piece);
}

// ---- pictures --------------------------------------------------------------------------------------------

static ng_result read_picture(const char *path)
{
    struct bytes b = read_file(path);
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

static void write_exr(const char *path)
{
    float pixels[20 * 8 * 4];
    uint32_t ids[20 * 8];
    for (uint32_t i = 0; i < NG_COUNT(pixels); i++)
        pixels[i] = (float)i;
    for (uint32_t i = 0; i < NG_COUNT(ids); i++)
        ids[i] = i;
    struct ng_exr_channel channels[] = {{"R", NG_EXR_HALF, pixels, 4},
                                        {"G", NG_EXR_HALF, pixels + 1, 4},
                                        {"B", NG_EXR_FLOAT, pixels + 2, 4},
                                        {"entity.id", NG_EXR_UINT, ids, 1}};
    struct ng_exr_text text = {"command", "lightformer render"};
    struct ng_exr_params params = {.width = 20,
                                   .height = 8,
                                   .channels = channels,
                                   .channel_count = NG_COUNT(channels),
                                   .texts = &text,
                                   .text_count = 1};
    assert_int_equal(ng_exr_write(path, &params), NG_OK);
}

// ---- checkpoints, manifests ------------------------------------------------------------------------------

static struct lf_reference *make_reference(void)
{
    struct lf_reference *reference;
    struct lf_reference_params params = {.width = 3, .height = 2};
    assert_int_equal(lf_reference_create(&params, &reference), NG_OK);
    return reference;
}

static void write_checkpoint(const char *path)
{
    struct lf_reference *reference = make_reference();
    assert_int_equal(lf_checkpoint_write(reference, path, 7), NG_OK);
    lf_reference_destroy(&reference);
}

static ng_result read_checkpoint(const char *path)
{
    struct lf_reference *reference = make_reference();
    ng_result r = lf_checkpoint_read(reference, path, 7);
    lf_reference_destroy(&reference);
    return r;
}

// Most are given the checksum of what they hold.
static void damage_checkpoint(struct bytes *b, struct ng_rng *r)
{
    mutate_bytes(b, r);
    if (b->data.count < 8 || fuzz_one_in(r, 8))
        return;
    uint64_t hash = ng_hash_bytes(0, b->data.items, b->data.count - 8);
    memcpy(b->data.items + b->data.count - 8, &hash, sizeof hash);
}

static void write_manifest(const char *path)
{
    char folder[512];
    struct lf_manifest m = {0};
    for (int i = 0; i < LF_SETTING_COUNT; i++) {
        snprintf(m.settings.items[i].key, sizeof m.settings.items[i].key, "key%d", i);
        snprintf(m.settings.items[i].value, sizeof m.settings.items[i].value, "value %d", i);
    }
    for (uint32_t i = 0; i < 3; i++)
        assert_int_equal(lf_manifest_put(&m, &(struct lf_shard){i * 4, i, 4}), NG_OK);
    snprintf(folder, sizeof folder, "%.*s", (int)(ng_path_name(path) - path), path);
    assert_int_equal(lf_manifest_write(folder, &m), NG_OK);
    lf_manifest_finish(&m);
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

static const struct kind text = {read_scene, damage_text}, glb = {read_scene, damage_glb},
                         picture = {read_picture, mutate_bytes}, layers = {read_layers, mutate_bytes},
                         checkpoint = {read_checkpoint, damage_checkpoint},
                         manifest = {read_manifest, damage_text}, library = {read_library, mutate_bytes},
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
    {"properties", &properties, write_properties},
    {"content/unit/accessors.glb", &glb, NULL},
    {"content/unit/animated_fields.glb", &glb, NULL},
    {"content/unit/light_mesh.glb", &glb, NULL},
    {"content/unit/subdivision.glb", &glb, NULL},
    {"tests/files/good/grey.jpg", &picture, NULL},
    {"tests/files/good/interlaced.png", &picture, NULL},
    {"content/unit/environment.hdr", &picture, NULL},
    {"picture.exr", &picture, write_exr},
    {"layers.exr", &layers, write_exr},
    {"samples", &checkpoint, write_checkpoint},
    {"manifest.json", &manifest, write_manifest},
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
        out[i] = read_file(path);
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
