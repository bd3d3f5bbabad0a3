// One scene a feature: materials, textures, accessors, animation, subdivision, nodes.
#include "content.h"
#include "pieces.h"
#include "stage.h"
#include "texture.h"

#include <stddef.h>
#include <stdio.h>

static const double quarter = 0.70710678118654752;

// ---- materials and textures ----

// Roughness grows from left to right; below dielectrics, above metals.
ng_result unit_materials(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_light(&g);
    for (int metal = 0; metal < 2; metal++)
        for (int i = 0; i < 5; i++) {
            char name[32];
            snprintf(name, sizeof name, "%s-%d", metal ? "metal" : "dielectric", i);
            struct glb_material m = {.name = name,
                                     .base_color = {0.8, metal ? 0.55 : 0.1, metal ? 0.25 : 0.08},
                                     .metallic = metal,
                                     .roughness = 0.05 + 0.2 * i};
            int mesh = stage_sphere(&g, name, 0.3, glb_add_material(&g, &m));
            stage_place(&g, name, mesh, (i - 2) * 0.7, metal ? 1.05 : 0.35, metal ? -0.4 : 0.0);
        }
    return glb_finish(&g, out);
}

ng_result unit_alpha_mask(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    int light = glb_add_light(&g, "point", "point", (const double[3]){1, 1, 1}, 10.0, 0, 0);
    glb_add_node(&g, &(struct glb_node){.name = "point", .translation = {0, 2.5, -1.5}, .light = light + 1});
    int material = glb_add_material(
        &g, &(struct glb_material){.name = "holes",
                                   .base_color = {1, 1, 1},
                                   .roughness = 0.6,
                                   .alpha_cutoff = 0.5,
                                   .double_sided = true,
                                   .base_color_texture =
                                       glb_texture(&g, "holes", texture_holes, GLB_REPEAT) + 1});
    stage_place(&g, "screen", stage_plane(&g, "screen", 1.8, 1.4, 1, material), 0, 0.75, 0);
    return glb_finish(&g, out);
}

ng_result unit_normal_map(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_light(&g);
    int material = glb_add_material(
        &g,
        &(struct glb_material){.name = "domes",
                               .base_color = {0.6, 0.62, 0.7},
                               .roughness = 0.35,
                               .normal_texture = glb_texture(&g, "domes", texture_domes, GLB_REPEAT) + 1});
    stage_place(&g, "panel", stage_plane(&g, "panel", 1.2, 1.2, 1, material), -0.8, 0.7, 0);
    stage_place(&g, "ball", stage_sphere(&g, "ball", 0.6, material), 0.8, 0.6, 0);
    return glb_finish(&g, out);
}

// A checker to the horizon (mip maps), and metallic-roughness from a texture.
ng_result unit_textures(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_light(&g);
    int tiles = glb_add_material(
        &g, &(struct glb_material){.name = "checker",
                                   .base_color = {1, 1, 1},
                                   .roughness = 0.7,
                                   .base_color_texture =
                                       glb_texture(&g, "checker", texture_checker, GLB_REPEAT) + 1});
    int metal = glb_add_material(
        &g, &(struct glb_material){.name = "stripes",
                                   .base_color = {0.8, 0.75, 0.7},
                                   .metallic = 1.0,
                                   .roughness = 1.0,
                                   .metallic_roughness_texture =
                                       glb_texture(&g, "stripes", texture_metal_stripes, GLB_REPEAT) + 1});
    int plain = stage_plane(&g, "plain", 60, 60, 60, tiles);
    glb_add_node(&g, &(struct glb_node){.name = "plain",
                                        .translation = {0, 0.01, -20},
                                        .rotation = {-quarter, 0, 0, quarter},
                                        .mesh = plain + 1});
    stage_place(&g, "ball", stage_sphere(&g, "ball", 0.7, metal), 0, 0.71, 0.4);
    return glb_finish(&g, out);
}

static struct stage_point trough(double u, double v, const void *user)
{
    NG_UNUSED(user);
    double angle = CONTENT_PI * (u - 0.5);
    struct vec3 n = vec3_make(sin(angle), 0, cos(angle));
    return (struct stage_point){vec3_add(vec3_scale(n, 0.5), vec3_make(0, v * 1.2, 0)), n};
}

// Two half cylinders that show their inside: one-sided on the left (nothing to see), double sided on the
// right.
ng_result unit_double_sided(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_light(&g);
    for (int both = 0; both < 2; both++) {
        const char *name = both ? "double-sided" : "one-sided";
        struct glb_material m = {
            .name = name, .base_color = {0.2, 0.5, 0.7}, .roughness = 0.5, .double_sided = both};
        int mesh = stage_patch(&g, name, &(struct stage_patch){.surface = trough, .columns = 24, .rows = 1},
                               glb_add_material(&g, &m));
        glb_add_node(&g, &(struct glb_node){.name = name,
                                            .translation = {both ? 0.8 : -0.8, 0, 0},
                                            .rotation = {0, 0.966, 0, 0.259},
                                            .mesh = mesh + 1});
    }
    return glb_finish(&g, out);
}

// ---- accessors ----

static struct stage_point panel(double u, double v, const void *user)
{
    NG_UNUSED(user);
    double x = 2.0 * u - 1.0, y = 2.0 * v - 1.0;
    return (struct stage_point){vec3_make(0.6 * x, 0.6 * y, 0.0), vec3_make(0, 0, 1)};
}

// The same flat panel three times: float data; 16- and 8-bit normalised texture coordinates; and a sparse
// accessor that pulls the panel's middle forward.
ng_result unit_accessors(struct bytes *out)
{
    enum { N = 8, MIDDLE = (N / 2) * (N + 1) + N / 2 };
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_light(&g);
    int material = glb_add_material(
        &g, &(struct glb_material){.name = "checker",
                                   .base_color = {1, 1, 1},
                                   .roughness = 0.6,
                                   .base_color_texture =
                                       glb_texture(&g, "checker", texture_checker, GLB_REPEAT) + 1});
    static const char *const names[2] = {"normalized-16", "normalized-8"};
    for (int i = 0; i < 2; i++) {
        struct stage_patch p = {.surface = panel, .columns = N, .rows = N, .uv_bits = i ? 8 : 16};
        stage_place(&g, names[i], stage_patch(&g, names[i], &p, material), i * 1.4 - 1.4, 0.65, 0);
    }
    double positions[(N + 1) * (N + 1)][3];
    uint32_t indices[N * N * 6];
    for (int i = 0; i < (N + 1) * (N + 1); i++) {
        int row = i / (N + 1);
        struct stage_point p = panel((double)(i % (N + 1)) / N, (double)row / N, NULL);
        positions[i][0] = p.position.x;
        positions[i][1] = p.position.y;
        positions[i][2] = p.position.z;
    }
    for (uint32_t f = 0; f < N * N; f++) {
        uint32_t a = f / N * (N + 1) + f % N, d = a + N + 1;
        const uint32_t quad[6] = {a, a + 1, d + 1, a, d + 1, d};
        for (uint32_t k = 0; k < 6; k++)
            indices[f * 6 + k] = quad[k];
    }
    const uint32_t moved[5] = {MIDDLE - N - 1, MIDDLE - 1, MIDDLE, MIDDLE + 1, MIDDLE + N + 1};
    double to[5][3];
    for (int i = 0; i < 5; i++) {
        to[i][0] = positions[moved[i]][0];
        to[i][1] = positions[moved[i]][1];
        to[i][2] = i == 2 ? 0.5 : 0.25;
    }
    int flat = glb_doubles(&g, positions[0], (N + 1) * (N + 1), 3, true);
    int sparse = glb_sparse(&g, flat, moved, to[0], 5, (const double[6]){-0.6, -0.6, 0, 0.6, 0.6, 0.5});
    // Without normals and texture coordinates: the reader computes the one and takes zero for the other.
    int mesh = glb_add_mesh(&g, &(struct glb_mesh){.name = "sparse",
                                                   .positions = sparse + 1,
                                                   .indices = glb_integers(&g, indices, N * N * 6, 1) + 1,
                                                   .material = material});
    stage_place(&g, "sparse", mesh, 1.4, 0.65, 0);
    return glb_finish(&g, out);
}

// ---- animation ----

// A ball on cubic splines, a box that turns linearly, a column that changes size in steps.
ng_result unit_interpolation(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_light(&g);
    int red = stage_material(&g, "red", 0.7, 0.12, 0.08, 0.3),
        blue = stage_material(&g, "blue", 0.1, 0.2, 0.6, 0.4);
    int ball = stage_place(&g, "cubic", stage_sphere(&g, "ball", 0.3, red), -1.4, 0.3, 0.6);
    int box = stage_place(&g, "linear", stage_box(&g, "box", 0.6, 0.6, 0.6, blue), 0.0, 0.8, -0.4);
    int column = stage_place(&g, "step", stage_box(&g, "column", 0.3, 0.6, 0.3, red), 1.3, 0.3, 0.0);
    int animation = glb_add_animation(&g, "interpolation");
    const double times[5] = {0, 1, 2, 3, 4};
    const double path[5][3][3] = {
        {{0, 3, 0}, {-1.4, 0.3, 0.6}, {0, 3, 0}},   {{2, 0, 0}, {-0.7, 1.3, 0.6}, {2, 0, 0}},
        {{0, -3, 0}, {0.0, 0.3, 0.6}, {0, 3, 0}},   {{-2, 0, 0}, {-0.7, 1.3, 0.9}, {-2, 0, 0}},
        {{0, -3, 0}, {-1.4, 0.3, 0.6}, {0, -3, 0}},
    };
    glb_add_channel(&g, animation,
                    &(struct glb_channel){.node = ball,
                                          .path = "translation",
                                          .interpolation = "CUBICSPLINE",
                                          .times = times,
                                          .values = &path[0][0][0],
                                          .keys = 5});
    const double turns[5][4] = {
        {0, 0, 0, 1}, {0, quarter, 0, quarter}, {0, 1, 0, 0}, {0, quarter, 0, -quarter}, {0, 0, 0, -1}};
    glb_add_channel(&g, animation,
                    &(struct glb_channel){.node = box,
                                          .path = "rotation",
                                          .interpolation = "LINEAR",
                                          .times = times,
                                          .values = turns[0],
                                          .keys = 5});
    const double sizes[5][3] = {{1, 1, 1}, {1, 2, 1}, {2, 1, 1}, {1, 3, 1}, {1, 1, 1}};
    glb_add_channel(&g, animation,
                    &(struct glb_channel){.node = column,
                                          .path = "scale",
                                          .interpolation = "STEP",
                                          .times = times,
                                          .values = sizes[0],
                                          .keys = 5});
    return glb_finish(&g, out);
}

// Fields of components that the standard cannot animate: a light's radiance and colour; beside an ordinary
// channel.
ng_result unit_animated_fields(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_props(&g);
    int node = glb_add_node(&g, &(struct glb_node){.name = "lamp",
                                                   .translation = {-1, 2.4, 0.6},
                                                   .rotation = {-quarter, 0, 0, quarter}});
    cJSON *light = glb_component(&g, NG_GLTF_NODES, node, "light_rectangle");
    glb_set(&g, light, "radiance", 8.0);
    glb_set_list(&g, light, "size", (const double[2]){1, 1}, 2);
    int animation = glb_add_animation(&g, "fields");
    const double times[3] = {0, 1, 2};
    const double places[3][3] = {{-1, 2.4, 0.6}, {1, 2.4, 0.6}, {-1, 2.4, 0.6}}, radiance[3] = {8, 2, 8};
    const double colors[3][3] = {{1, 0.3, 0.2}, {0.3, 1, 0.4}, {1, 0.3, 0.2}};
    glb_add_channel(&g, animation,
                    &(struct glb_channel){.node = node,
                                          .path = "translation",
                                          .interpolation = "LINEAR",
                                          .times = times,
                                          .values = places[0],
                                          .keys = 3});
    glb_add_channel(&g, animation,
                    &(struct glb_channel){.node = node,
                                          .component = "light_rectangle",
                                          .path = "radiance",
                                          .width = 1,
                                          .interpolation = "LINEAR",
                                          .times = times,
                                          .values = radiance,
                                          .keys = 3});
    glb_add_channel(&g, animation,
                    &(struct glb_channel){.node = node,
                                          .component = "light_rectangle",
                                          .path = "color",
                                          .width = 3,
                                          .interpolation = "LINEAR",
                                          .times = times,
                                          .values = colors[0],
                                          .keys = 3});
    return glb_finish(&g, out);
}

// ---- subdivision ----

// A 3 x 3 sheet with an open boundary, its inner points lifted.
static void build_sheet(struct cage *c)
{
    for (int i = 0; i < 16; i++) {
        int column = i % 4, row = i / 4;
        bool inner = column % 3 && row % 3;
        cage_point(c, vec3_make((column - 1.5) * 0.3, inner ? 0.4 : 0.0, (1.5 - row) * 0.3));
    }
    for (uint32_t f = 0; f < 9; f++) {
        uint32_t a = f / 3 * 4 + f % 3;
        cage_quad(c, a, a + 1, a + 5, a + 4);
    }
}

// Cubes with creases of growing sharpness, a cube with one sharp corner, a pyramid of triangles, sheets with
// both boundary rules.
ng_result unit_subdivision(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_light(&g);
    int material = stage_material(&g, "clay", 0.7, 0.45, 0.3, 0.35);
    static const double sharpness[4] = {0, 1, 2.5, 10};
    for (int i = 0; i < 4; i++) {
        struct cage c = {0};
        char name[32];
        cage_box(&c, vec3_make(-0.35, -0.35, -0.35), vec3_make(0.35, 0.35, 0.35), sharpness[i]);
        snprintf(name, sizeof name, "crease-%d", i);
        stage_place(&g, name, glb_cage_mesh(&g, name, &c, material, 3), (i - 1.5) * 0.9, 0.36, -0.3);
        cage_finish(&c);
    }
    struct cage corner = {0}, pyramid = {0}, sheet = {0};
    cage_box(&corner, vec3_make(-0.35, -0.35, -0.35), vec3_make(0.35, 0.35, 0.35), 0);
    cage_add_corner(&corner, 7, 10);
    stage_place(&g, "corner", glb_cage_mesh(&g, "corner", &corner, material, 3), -1.1, 0.36, 0.8);
    static const double tip[5][3] = {
        {-0.4, 0, 0.4}, {0.4, 0, 0.4}, {0.4, 0, -0.4}, {-0.4, 0, -0.4}, {0, 0.9, 0}};
    for (int i = 0; i < 5; i++)
        cage_point(&pyramid, vec3_make(tip[i][0], tip[i][1], tip[i][2]));
    cage_quad(&pyramid, 3, 2, 1, 0);
    for (uint32_t i = 0; i < 4; i++)
        cage_face(&pyramid, (const uint32_t[3]){i, (i + 1) % 4, 4}, 3);
    stage_place(&g, "triangles", glb_cage_mesh(&g, "triangles", &pyramid, material, 3), 0.0, 0.1, 0.8);
    build_sheet(&sheet);
    int look = glb_add_material(
        &g, &(struct glb_material){
                .name = "sheet", .base_color = {0.25, 0.5, 0.6}, .roughness = 0.5, .double_sided = true});
    static const char *const rules[2] = {"edge_only", "edge_and_corner"};
    for (int i = 0; i < 2; i++) {
        int mesh = glb_cage_mesh_bounded(&g, rules[i], &sheet, look, 3, rules[i]);
        stage_place(&g, rules[i], mesh, 0.75 + 0.95 * i, 0.1, 0.9);
    }
    cage_finish(&corner);
    cage_finish(&pyramid);
    cage_finish(&sheet);
    return glb_finish(&g, out);
}

// ---- nodes ----

// A knight and its mirror image: one mesh, one node with a negative scale, which turns the winding round.
ng_result unit_mirrored(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_light(&g);
    struct cage c = {0};
    piece_build(PIECE_KNIGHT, &c);
    int mesh = glb_cage_mesh(&g, "knight", &c, stage_material(&g, "ivory", 0.8, 0.72, 0.58, 0.2), 2);
    cage_finish(&c);
    for (int i = 0; i < 2; i++) {
        double side = i ? 1.0 : -1.0;
        glb_add_node(&g, &(struct glb_node){.name = i ? "knight" : "mirrored",
                                            .translation = {side * 0.55, 0, 0},
                                            .rotation = {0, 0.5, 0, 0.866025},
                                            .scale = {18, 18, side * 18},
                                            .mesh = mesh + 1});
    }
    return glb_finish(&g, out);
}

// An arm of six links, each the child of the one before, smaller and turning on it.
ng_result unit_hierarchy(struct bytes *out)
{
    struct glb g;
    stage_init(&g);
    stage_add_wall(&g);
    stage_add_light(&g);
    int material = stage_material(&g, "link", 0.8, 0.45, 0.1, 0.3);
    int mesh = stage_box(&g, "link", 0.16, 0.4, 0.16, material);
    int animation = glb_add_animation(&g, "curl");
    for (int i = 0, parent = 0; i < 6; i++) {
        char name[32];
        snprintf(name, sizeof name, "link-%d", i);
        double shrink = i ? 0.9 : 1.0;
        int joint = glb_add_node(&g, &(struct glb_node){.name = name,
                                                        .parent = parent,
                                                        .translation = {i ? 0.0 : -0.6, i ? 0.42 : 0.0, 0},
                                                        .scale = {shrink, shrink, shrink}});
        glb_add_node(&g,
                     &(struct glb_node){
                         .name = "box", .parent = joint + 1, .translation = {0, 0.2, 0}, .mesh = mesh + 1});
        parent = joint + 1;
        const double times[3] = {0, 1.5, 3}, bend = 0.5 * (i ? -0.35 : -0.1);
        const double turns[3][4] = {{0, 0, 0, 1}, {0, 0, sin(bend), cos(bend)}, {0, 0, 0, 1}};
        glb_add_channel(&g, animation,
                        &(struct glb_channel){.node = joint,
                                              .path = "rotation",
                                              .interpolation = "LINEAR",
                                              .times = times,
                                              .values = turns[0],
                                              .keys = 3});
    }
    return glb_finish(&g, out);
}
