// Observation against closed forms, and small data sets of the chess scene from end to end.
#include "test.h"

#include "app/stage.h"
#include "asset/image.h"
#include "base/file.h"
#include "base/half.h"
#include "components/components.h"
#include "components/light_directional.h"
#include "components/light_point.h"
#include "gpu/device.h"
#include "lightformer/dataset/dataset.h"
#include "lightformer/dataset/manifest.h"
#include "render/frame.h"

#include <math.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#define OK(call) assert_int_equal((call), NG_OK)

// ---- observation -----------------------------------------------------------------------------------------
// A room from -2 to 2 on each axis, albedo 0.5, one mesh that faces inwards. The camera looks at it from (0,
// 0, 1) along -Z.
#define ALBEDO 0.5f
#define SIZE   32u

struct room {
    float positions[24][3], normals[24][3], tangents[24][4], uvs[24][2];
    uint32_t indices[36];
    struct ng_snapshot_mesh mesh;
    struct ng_snapshot_instance instance;
    struct ng_snapshot_material material;
    struct ng_snapshot_light light;
    struct ng_snapshot snapshot;
    struct ng_gpu *gpu;
    struct lf_capture *observer;
};

static void build_walls(struct room *r)
{
    for (int w = 0; w < 6; w++) {
        int axis = w / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
        float side = w % 2 ? 2.0f : -2.0f;
        for (int k = 0; k < 4; k++) {
            int v = w * 4 + k;
            float x = k == 0 || k == 3 ? -2.0f : 2.0f;
            r->positions[v][axis] = side;
            r->positions[v][a] = side < 0 ? x : -x;
            r->positions[v][b] = k < 2 ? -2 : 2;
            r->normals[v][axis] = side < 0 ? 1 : -1;
            r->tangents[v][a] = r->tangents[v][3] = 1;
        }
        for (uint32_t k = 0; k < 6; k++)
            r->indices[w * 6 + (int)k] = (uint32_t)w * 4 + (const uint32_t[]){0, 1, 2, 0, 2, 3}[k];
    }
}

static void identity(float m[16])
{
    memset(m, 0, 16 * sizeof *m);
    for (int i = 0; i < 4; i++)
        m[i * 5] = 1;
}

static int open_room(void **state)
{
    struct room *r = calloc(1, sizeof *r);
    assert_non_null(r);
    build_walls(r);
    r->mesh = (struct ng_snapshot_mesh){.key = 1,
                                        .revision = 1,
                                        .vertex_count = 24,
                                        .index_count = 36,
                                        .positions = r->positions[0],
                                        .normals = r->normals[0],
                                        .tangents = r->tangents[0],
                                        .uvs = r->uvs[0],
                                        .indices = r->indices,
                                        .bounds_min = {-2, -2, -2},
                                        .bounds_max = {2, 2, 2}};
    r->material = (struct ng_snapshot_material){.base_color = {ALBEDO, ALBEDO, ALBEDO},
                                                .roughness = 1,
                                                .alpha = 1,
                                                .specular = 1,
                                                .specular_color = {0.04f, 0.04f, 0.04f},
                                                .textures = NG_SNAPSHOT_NO_TEXTURES};
    r->instance = (struct ng_snapshot_instance){.entity = {1 | 1ull << 32},
                                                .light = NG_NONE,
                                                .version = 1,
                                                .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                                                .previous_matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                                                .bounds_min = {-2, -2, -2},
                                                .bounds_max = {2, 2, 2}};
    r->snapshot = (struct ng_snapshot){.scene_radius = 4,
                                       .mesh_count = 1,
                                       .instance_count = 1,
                                       .material_count = 1,
                                       .light_count = 1,
                                       .meshes = &r->mesh,
                                       .instances = &r->instance,
                                       .materials = &r->material,
                                       .lights = &r->light,
                                       .environment = NG_NONE};
    r->snapshot.camera = (struct ng_snapshot_camera){
        .position = {0, 0, 1}, .fov_y = NG_PI / 2, .near_plane = 0.01f, .exposure = 1};
    identity(r->snapshot.camera.view);
    r->snapshot.camera.view[14] = -1;
    memcpy(r->snapshot.camera.previous_view, r->snapshot.camera.view, sizeof r->snapshot.camera.view);
    OK(ng_gpu_create(&(struct ng_gpu_params){0}, &r->gpu));
    OK(lf_capture_create(r->gpu, NULL, &r->observer));
    *state = r;
    return 0;
}

static int close_room(void **state)
{
    struct room *r = *state;
    ng_light_finish(&r->light.source);
    lf_capture_destroy(&r->observer);
    ng_gpu_destroy(&r->gpu);
    free(r);
    return 0;
}

static void light_room(struct room *r, ng_component component, const void *params, size_t size,
                       const float matrix[16], struct lf_captured_frame *out)
{
    r->light = (struct ng_snapshot_light){
        .entity = {9 | 1ull << 32}, .name = "lamp", .image = NG_NONE, .version = 1};
    r->light.source.type = ng_light_type_of(component);
    r->light.source.scene_radius = r->snapshot.scene_radius;
    memcpy(r->light.source.params, params, size);
    memcpy(r->light.source.matrix, matrix, sizeof r->light.source.matrix);
    OK(ng_light_prepare(&r->light.source));
    r->light.power = ng_light_power(&r->light.source);
    OK(lf_capture_frame(r->observer,
                        &(struct lf_capture_params){.snapshot = &r->snapshot, .width = SIZE, .height = SIZE},
                        out));
    assert_int_equal(out->light_count, 1);
}

static void a_room_reflects_what_the_light_sends(void **state)
{
    struct room *r = *state;
    const struct ng_light_point point = {.on = true, .color = {1, 0.5f, 0.25f}, .intensity = 3};
    struct lf_captured_frame o;
    float matrix[16], sum[3] = {0}, vpls[3] = {0};
    identity(matrix);
    memcpy(matrix + 12, (const float[]){0.3f, -0.4f, 0.5f}, 3 * sizeof *matrix);
    light_room(r, NG_LIGHT_POINT, &point, sizeof point, matrix, &o);
    const struct lf_captured_light *l = &o.lights[0];
    assert_int_equal(l->rsm_views, 6);
    for (size_t i = 0; i < 6 * NG_RSM_SIZE * NG_RSM_SIZE; i++) {
        const float *p = l->position + 4 * i;
        float along = 0, on_wall = fmaxf(fabsf(p[0]), fmaxf(fabsf(p[1]), fabsf(p[2])));
        assert_true(p[3] > 0 && fabsf(on_wall - 2) < 1e-3f);
        for (size_t c = 0; c < 3; c++) {
            sum[c] += l->flux[4 * i + c];
            along += ng_half_to_float(l->normal[4 * i + c]) * (l->data.proxy[c] - p[c]);
        }
        assert_true(along > 0); // normals face the light
    }
    for (uint32_t i = 0; i < o.vpl_count; i++)
        for (int c = 0; c < 3; c++)
            vpls[c] += l->vpls[i].power[c] / (float)o.vpl_count;
    for (int c = 0; c < 3; c++) {
        float power = 4 * NG_PI * point.intensity * point.color[c];
        assert_true(fabsf(l->power[c] - power) < 1e-3f * power);
        assert_true(fabsf(vpls[c] - power) < 1e-3f * power);
        // Diffuse albedo, and a few percent for the specular lobe.
        assert_true(sum[c] > ALBEDO * power * 0.998f && sum[c] < (ALBEDO + 0.05f) * power);
    }
}

// Points on every wall, seen through the maps that the renderer drew: nothing is before them.
static void lookups_agree_with_the_maps(void **state)
{
    struct room *r = *state;
    const struct ng_light_point point = {.on = true, .color = {1, 1, 1}, .intensity = 1};
    struct lf_captured_frame o;
    float matrix[16];
    identity(matrix);
    memcpy(matrix + 12, (const float[]){0.3f, -0.4f, 0.5f}, 3 * sizeof *matrix);
    light_room(r, NG_LIGHT_POINT, &point, sizeof point, matrix, &o);
    const struct lf_captured_light *l = &o.lights[0];
    const struct lf_depth_map map = {&l->data, l->depth, l->depth_views, l->face_size};
    for (int w = 0; w < 6; w++)
        for (int i = -9; i <= 9; i++)
            for (int k = -9; k <= 9; k++) {
                float p[3], square = 0;
                p[w / 2] = w % 2 ? 2 : -2;
                p[(w / 2 + 1) % 3] = 0.21f * (float)i;
                p[(w / 2 + 2) % 3] = 0.21f * (float)k;
                for (int c = 0; c < 3; c++)
                    square += (p[c] - matrix[12 + c]) * (p[c] - matrix[12 + c]);
                struct lf_shadow_distance s = lf_shadow_lookup(&map, p);
                assert_true(fabsf(s.receiver - sqrtf(square)) < 1e-4f);
                assert_true(fabsf(s.occluder - s.receiver) < 0.02f * s.receiver);
            }
    // The G-buffer is of the same room: every pixel is lit.
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        const float *p = o.gbuffer.position + 4 * i;
        struct lf_shadow_distance s = lf_shadow_lookup(&map, p);
        assert_true(p[3] > 0 && fabsf(s.occluder - s.receiver) < 0.02f * s.receiver);
        assert_true(fabsf(ng_half_to_float(o.gbuffer.diffuse[4 * i]) - ALBEDO * 1.0f) < 1e-3f);
    }
}

// The sun stands above the closed room: what is on the floor is 4 m behind the ceiling.
static void the_ceiling_shadows_the_floor(void **state)
{
    struct room *r = *state;
    const struct ng_light_directional sun = {.on = true, .color = {1, 1, 1}, .irradiance = 1};
    struct lf_captured_frame o;
    const float down[16] = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}; // -Z becomes -Y
    light_room(r, NG_LIGHT_DIRECTIONAL, &sun, sizeof sun, down, &o);
    const struct lf_captured_light *l = &o.lights[0];
    const struct lf_depth_map map = {&l->data, l->depth, l->depth_views, l->face_size};
    for (int i = -9; i <= 9; i++)
        for (int k = -9; k <= 9; k++) {
            const float p[3] = {0.2f * (float)i, -2, 0.2f * (float)k};
            struct lf_shadow_distance s = lf_shadow_lookup(&map, p);
            assert_true(fabsf(s.receiver - 6) < 1e-4f && fabsf(s.occluder - 2) < 1e-3f); // radius 4
        }
}

// ---- data sets -------------------------------------------------------------------------------------------

static struct ng_stage *stage;

static int open_stage(void **state)
{
    NG_UNUSED(state);
    OK(ng_stage_create(&(struct ng_stage_params){.scene = "content/chess/chess.glb", .threads = 2}, &stage));
    return 0;
}

static int close_stage(void **state)
{
    NG_UNUSED(state);
    ng_stage_destroy(&stage);
    return 0;
}

// A new, empty place.
static void new_directory(char out[512], const char *name)
{
    char full[64];
    static int number;
    snprintf(full, sizeof full, "%s-%ld-%d", name, (long)getpid(), number++);
    test_path(out, 512, full);
}

static struct lf_dataset_params small(const char *directory)
{
    return (struct lf_dataset_params){.world = stage->world,
                                      .assets = stage->assets,
                                      .gpu = stage->gpu,
                                      .jobs = stage->jobs,
                                      .directory = directory,
                                      .program = "test",
                                      .scene = "chess.glb",
                                      .scene_hash = 7,
                                      .count = 5,
                                      .size = 64,
                                      .crop = 24,
                                      .crops = 2,
                                      .spp = 8,
                                      .shard = 4, // two samples
                                      .vpls = 50};
}

static struct lf_dataset_report make(const struct lf_dataset_params *p)
{
    struct lf_dataset_report report;
    OK(lf_dataset_make(p, &report));
    return report;
}

static const struct lf_shard shards[] = {{0, 0, 2}, {2, 0, 2}, {4, 0, 1}};

static void shard_path(const char *directory, int shard, char out[600])
{
    assert_true(lf_shard_path(directory, &shards[shard], out, 600));
}

static void assert_equal_files(const char *a, const char *b)
{
    void *x, *y;
    size_t n, m;
    OK(ng_file_read(a, 0, &x, &n));
    OK(ng_file_read(b, 0, &y, &m));
    assert_int_equal(n, m);
    assert_memory_equal(x, y, n);
    free(x);
    free(y);
}

static void assert_equal_sets(const char *a, const char *b)
{
    char x[600], y[600];
    for (int i = 0; i < 3; i++) {
        shard_path(a, i, x);
        shard_path(b, i, y);
        assert_equal_files(x, y);
    }
    snprintf(x, sizeof x, "%s/manifest.json", a);
    snprintf(y, sizeof y, "%s/manifest.json", b);
    assert_equal_files(x, y);
}

static void copy_file(const char *from, const char *to)
{
    void *data;
    size_t size;
    OK(ng_file_read(from, 0, &data, &size));
    OK(ng_file_write(to, data, size));
    free(data);
}

static const struct lf_tensor *find(const struct lf_tensors *t, const char *name, uint64_t count)
{
    const struct lf_tensor *found = lf_tensors_find(t, name);
    if (!found || found->size != count * lf_dtype_size(found->dtype))
        fail_msg("%s: missing, or not %d numbers", name, (int)count);
    return found;
}

static float number(const struct lf_tensor *t, size_t i)
{
    return t->dtype == LF_F32 ? ((const float *)t->data)[i]
                              : ng_half_to_float(((const uint16_t *)t->data)[i]);
}

// Every input of the network is there under its own name, its numbers are numbers, and those that belong
// together agree: distances with places, unshadowed light with the target.
static void check_inputs(const struct lf_tensors *t)
{
    enum { N = 24 * 24, CROPS = 2, LIGHTS = 2, VPLS = 50 };
    static const char *const names[] = {
#define LF_INPUT(id, name, domain, channels, when) name,
#include "lightformer/net/inputs.inc"
#undef LF_INPUT
    };
    for (size_t n = 0; n < NG_COUNT(names); n++) {
        char full[64];
        snprintf(full, sizeof full, "2/%s", names[n]);
        const struct lf_tensor *input = lf_tensors_find(t, full);
        if (!input) {
            fail_msg("%s is missing", full);
            return; // static analysis does not know that cmocka does not come back
        }
        for (size_t i = 0; i < input->size / lf_dtype_size(input->dtype); i++)
            assert_true(isfinite(number(input, i)));
    }
    const struct lf_tensor *position = find(t, "2/pixel.position", CROPS * 3 * N),
                           *mask = find(t, "2/pixel.mask", CROPS * N),
                           *vpl = find(t, "2/vpl.position", LIGHTS * 3 * VPLS),
                           *offset = find(t, "2/vpl.offset", LIGHTS * 3 * VPLS),
                           *distance = find(t, "2/view.distance", CROPS * LIGHTS * N),
                           *occluder = find(t, "2/view.occluder", CROPS * LIGHTS * N),
                           *diffuse = find(t, "2/view.diffuse", CROPS * LIGHTS * 3 * N),
                           *glossy = find(t, "2/view.glossy", CROPS * LIGHTS * 3 * N),
                           *share = find(t, "2/light.share", LIGHTS), *unit = find(t, "2/frame.radiance", 1),
                           *unshadowed = find(t, "2/target.unshadowed", CROPS * 3 * N);
    double ours = 0, truth = 0;
    for (size_t k = 0; k < CROPS; k++)
        for (size_t i = 0; i < N; i++) {
            assert_true(number(mask, k * N + i) == 1); // the room is closed
            for (size_t l = 0; l < LIGHTS; l++) {
                float square = 0;
                for (size_t c = 0; c < 3; c++) {
                    size_t row = (l * 3 + c) * VPLS, at = ((k * LIGHTS + l) * 3 + c) * N + i;
                    float way =
                        number(position, (k * 3 + c) * N + i) - (number(vpl, row) - number(offset, row));
                    square += way * way;
                    ours += (double)((number(diffuse, at) + number(glossy, at)) * number(share, l) *
                                     number(unit, 0));
                }
                size_t at = (k * LIGHTS + l) * N + i;
                assert_true(fabsf(number(distance, at) - sqrtf(square)) < 1e-5f);
                assert_true(number(occluder, at) > 0 && number(occluder, at) <= number(distance, at));
            }
            for (size_t c = 0; c < 3; c++)
                truth += (double)number(unshadowed, (k * 3 + c) * N + i);
        }
    assert_true(fabs(ours - truth) < 0.03 * truth);
}

static void shards_hold_inputs_and_targets(void **state)
{
    NG_UNUSED(state);
    char directory[512], path[600];
    struct lf_tensors t;
    new_directory(directory, "content");
    struct lf_dataset_params p = small(directory);
    struct lf_dataset_report report = make(&p);
    assert_int_equal(report.samples, 5);
    assert_int_equal(report.crops, 10);
    assert_int_equal(report.shards, 3);
    shard_path(directory, 1, path);
    OK(lf_tensors_read(path, &t));
    enum { N = 24 * 24, CROPS = 2 };
    const float *emission = find(&t, "2/gbuffer.emission", CROPS * 3 * N)->data;
    const float *unshadowed = find(&t, "2/target.unshadowed", CROPS * 3 * N)->data;
    const uint16_t *shadow = find(&t, "2/target.shadow", CROPS * 3 * N)->data;
    const float *indirect = find(&t, "2/target.indirect", CROPS * 3 * N)->data;
    const int32_t *origin = find(&t, "2/crop.origin", CROPS * 2)->data;
    find(&t, "2/camera.view", 16);
    double light = 0;
    for (size_t k = 0; k < CROPS; k++) {
        assert_true(origin[k * 2] >= 0 && origin[k * 2] <= 64 - 24);
        for (size_t i = 0; i < 3 * N; i++) {
            size_t at = k * 3 * N + i;
            float ratio = ng_half_to_float(shadow[at]);
            assert_true(ratio >= 0 && ratio <= 1.001f && unshadowed[at] >= 0 && indirect[at] >= 0);
            assert_true(emission[at] >= 0);
            light += (double)indirect[at];
        }
    }
    assert_true(light > 0);
    check_inputs(&t);
    lf_tensors_finish(&t);
    char sheet[600];
    struct ng_image image;
    snprintf(sheet, sizeof sheet, "%s/sheet.png", directory);
    OK(lf_dataset_contact_sheet(directory, sheet, 3));
    void *png;
    size_t size;
    OK(ng_file_read(sheet, 0, &png, &size));
    OK(ng_image_decode(sheet, png, size, &(struct ng_image_params){.no_mips = true}, &image));
    free(png);
    assert_int_equal(image.width, 40 * (24 + 4) + 4); // 14 tiles of a crop and 13 of each of two lights
    assert_int_equal(image.height, 3 * (24 + 4) + 4);
    ng_image_finish(&image);
}

static bool stop_after_three(void *user, uint32_t done, uint32_t count)
{
    NG_UNUSED(user);
    NG_UNUSED(count);
    return done < 3;
}

// Interrupted, damaged, made in parts, by other numbers of threads: always the same files.
static void however_made_the_files_are_the_same(void **state)
{
    NG_UNUSED(state);
    char whole[512], parts[512], other[512], path[600], to[600];
    struct lf_dataset_contents contents;
    struct lf_dataset_report report;
    struct test_log log;
    new_directory(whole, "whole");
    new_directory(parts, "parts");
    new_directory(other, "other");
    struct lf_dataset_params p = small(whole);
    make(&p);
    OK(lf_dataset_check(whole, &contents));
    assert_int_equal(contents.shards, 3);
    assert_int_equal(contents.samples, 5);

    p.directory = parts; // interrupted in the second shard
    p.progress = stop_after_three;
    report = make(&p);
    assert_int_equal(report.samples, 3);
    OK(lf_dataset_check(parts, &contents));
    assert_int_equal(contents.shards, 1);
    p.progress = NULL; // and taken up, on one thread
    p.jobs = NULL;
    report = make(&p);
    assert_int_equal(report.kept, 1);
    assert_int_equal(report.samples, 3);
    assert_equal_sets(whole, parts);
    report = make(&p); // nothing to do
    assert_int_equal(report.kept, 3);
    assert_int_equal(report.samples, 0);

    void *data; // a bit flips
    size_t size;
    shard_path(parts, 1, path);
    OK(ng_file_read(path, 0, &data, &size));
    ((unsigned char *)data)[size - 1000] ^= 1;
    OK(ng_file_write(path, data, size));
    free(data);
    test_log_begin(&log);
    assert_int_equal(lf_dataset_check(parts, &contents), NG_ERROR_FORMAT);
    assert_int_equal(contents.damaged, 1);
    assert_int_equal(log.errors, 1);
    test_log_begin(&log);
    report = make(&p);
    test_log_end(&log);
    assert_true(log.errors == 0 && log.warnings == 1);
    assert_int_equal(report.redone, 1);
    assert_int_equal(report.samples, 2);
    assert_equal_sets(whole, parts);

    p.directory = other; // two machines: seeds 0 to 3, and 4
    p.seed = 4;
    p.count = 1;
    make(&p);
    for (int i = 0; i < 2; i++) {
        shard_path(whole, i, path);
        shard_path(other, i, to);
        copy_file(path, to);
    }
    p.seed = 0;
    p.count = 5;
    report = make(&p);
    assert_int_equal(report.kept, 3);
    assert_equal_sets(whole, other);
}

static void refused(const struct lf_dataset_params *p, ng_result expected, const char *text)
{
    struct lf_dataset_report report;
    struct test_log log;
    test_log_begin(&log);
    ng_result result = lf_dataset_make(p, &report);
    test_log_end(&log);
    if (result != expected || log.errors != 1 || !strstr(log.text, text))
        fail_msg("expected %d and \"%s\", not %d and \"%s\"", expected, text, result, log.text);
}

// Targets of another set are taken where they are of the same samples and settings; what lacks is traced.
static void targets_may_be_taken(void **state)
{
    NG_UNUSED(state);
    char traced[512], taken[512], path[600];
    struct lf_dataset_report report;
    new_directory(traced, "traced");
    new_directory(taken, "taken");
    struct lf_dataset_params p = small(traced);
    make(&p);
    struct lf_tensors t; // a target that says where it comes from
    shard_path(traced, 0, path);
    OK(lf_tensors_read(path, &t));
    ((float *)find(&t, "1/target.indirect", 3 * 24 * 24 * 2)->data)[7] = 1234;
    OK(lf_tensors_write(&t, path));
    lf_tensors_finish(&t);
    shard_path(traced, 2, path);
    remove(path);
    snprintf(path, sizeof path, "%s/manifest.json", traced);
    remove(path);
    p.count = 4;
    make(&p); // lists what is left
    p = small(taken);
    p.targets = traced;
    report = make(&p);
    assert_int_equal(report.samples, 5);
    shard_path(taken, 0, path);
    OK(lf_tensors_read(path, &t));
    assert_true(((float *)find(&t, "1/target.indirect", 3 * 24 * 24 * 2)->data)[7] == 1234);
    lf_tensors_finish(&t);
    p.directory = path;
    new_directory(path, "others");
    p.spp = 3;
    refused(&p, NG_ERROR_FORMAT, "spp is \"8\" there");
    p.targets = "/nowhere";
    refused(&p, NG_ERROR_NOT_FOUND, "no data set");
}

// A range that ends within a shard, and later goes on.
static void a_longer_run_replaces_the_last_shard(void **state)
{
    NG_UNUSED(state);
    char directory[512], path[600];
    struct lf_dataset_contents contents;
    new_directory(directory, "longer");
    struct lf_dataset_params p = small(directory);
    p.count = 3;
    make(&p);
    assert_true(
        lf_shard_path(directory, &(struct lf_shard){.first_seed = 2, .samples = 1}, path, sizeof path));
    assert_true(ng_file_exists(path));
    p.count = 4;
    make(&p);
    assert_false(ng_file_exists(path));
    OK(lf_dataset_check(directory, &contents));
    assert_int_equal(contents.shards, 2);
    assert_int_equal(contents.samples, 4);
}

static void what_makes_no_sense_is_refused(void **state)
{
    NG_UNUSED(state);
    char directory[512];
    struct lf_dataset_contents contents;
    struct test_log log;
    new_directory(directory, "refused");
    struct lf_dataset_params p = small(directory);
    p.spp = 0;
    refused(&p, NG_ERROR_FORMAT, "spp");
    p = small(directory);
    p.size = 100000;
    refused(&p, NG_ERROR_FORMAT, "4096");
    p = small(directory);
    p.crop = 65;
    refused(&p, NG_ERROR_FORMAT, "larger than the frame");
    p = small(directory);
    p.crops = 0;
    refused(&p, NG_ERROR_FORMAT, "at least 1");
    p = small(directory);
    p.count = 0;
    refused(&p, NG_ERROR_FORMAT, "at least one");
    p = small(directory);
    p.seed = (uint64_t)1 << 32;
    refused(&p, NG_ERROR_FORMAT, "seeds go up to");
    p = small(directory);
    p.crops = 1u << 30;
    refused(&p, NG_ERROR_MEMORY, "smaller");
    p = small(directory);
    p.count = 1;
    make(&p);
    p.spp = 3;
    refused(&p, NG_ERROR_FORMAT, "spp is \"8\" there");
    p = small(directory);
    p.depth = 3;
    refused(&p, NG_ERROR_FORMAT, "depth is \"0\" there");
    test_log_begin(&log);
    assert_int_equal(lf_dataset_check("/nowhere", &contents), NG_ERROR_NOT_FOUND);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
}

static void find_unfinished(void *user, const char *name)
{
    *(bool *)user |= strstr(name, ".tmp-") != NULL;
}

// A limit on the size of files stands for a full disk: write() fails in the same way.
static void a_full_disk_leaves_whole_shards(void **state)
{
    NG_UNUSED(state);
    char directory[512], path[600];
    bool unfinished = false;
    struct lf_dataset_contents contents;
    struct rlimit limit, tight;
    new_directory(directory, "full");
    struct lf_dataset_params p = small(directory);
    p.count = 2;
    make(&p);
    p.count = 5;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    signal(SIGXFSZ, SIG_IGN);
    tight = (struct rlimit){.rlim_cur = 100000, .rlim_max = limit.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &tight), 0);
    refused(&p, NG_ERROR_IO, "shard-0000000002");
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    shard_path(directory, 1, path);
    OK(ng_file_list(directory, find_unfinished, &unfinished));
    assert_false(ng_file_exists(path) || unfinished);
    OK(lf_dataset_check(directory, &contents));
    assert_int_equal(contents.shards, 1);
    assert_int_equal(make(&p).samples, 3);
}

static void whole_frames(void **state)
{
    NG_UNUSED(state);
    char directory[512], path[600];
    struct lf_tensors t;
    new_directory(directory, "frames");
    struct lf_dataset_params p = small(directory);
    p.crop = 0;
    p.count = 1;
    p.size = 16;
    p.shard = 1;
    make(&p);
    assert_true(lf_shard_path(directory, &(struct lf_shard){.samples = 1}, path, sizeof path));
    OK(lf_tensors_read(path, &t));
    find(&t, "0/target.indirect", 3 * 16 * 16);
    const int32_t *origin = find(&t, "0/crop.origin", 2)->data;
    assert_true(origin[0] == 0 && origin[1] == 0);
    lf_tensors_finish(&t);
}

int main(void)
{
    const struct CMUnitTest observation[] = {
        cmocka_unit_test_setup_teardown(a_room_reflects_what_the_light_sends, open_room, close_room),
        cmocka_unit_test_setup_teardown(lookups_agree_with_the_maps, open_room, close_room),
        cmocka_unit_test_setup_teardown(the_ceiling_shadows_the_floor, open_room, close_room),
    };
    const struct CMUnitTest sets[] = {
        cmocka_unit_test(shards_hold_inputs_and_targets),
        cmocka_unit_test(however_made_the_files_are_the_same),
        cmocka_unit_test(targets_may_be_taken),
        cmocka_unit_test(a_longer_run_replaces_the_last_shard),
        cmocka_unit_test(what_makes_no_sense_is_refused),
        cmocka_unit_test(a_full_disk_leaves_whole_shards),
        cmocka_unit_test(whole_frames),
    };
    int failed = cmocka_run_group_tests(observation, NULL, NULL);
    return failed + cmocka_run_group_tests(sets, open_stage, close_stage);
}
