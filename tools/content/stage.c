#include "stage.h"

#include <stdlib.h>

int stage_patch(struct glb *g, const char *name, const struct stage_patch *p, int material)
{
    uint32_t across = p->columns + 1, count = across * (p->rows + 1), faces = p->columns * p->rows;
    double *positions = calloc((size_t)count * 3, sizeof *positions);
    double *normals = calloc((size_t)count * 3, sizeof *normals);
    double *uvs = calloc((size_t)count * 2, sizeof *uvs);
    uint32_t *indices = calloc((size_t)faces * 6, sizeof *indices);
    g->w.failed |= !positions || !normals || !uvs || !indices;
    for (uint32_t i = 0; i < count && !g->w.failed; i++) {
        uint32_t row = i / across;
        double u = (double)(i % across) / p->columns, v = (double)row / p->rows;
        double repeat = p->repeat > 0.0 ? p->repeat : 1.0;
        struct stage_point at = p->surface(u, v, p->user);
        ((struct vec3 *)positions)[i] = at.position;
        ((struct vec3 *)normals)[i] = at.normal;
        uvs[i * 2] = u * repeat;
        uvs[i * 2 + 1] = (1.0 - v) * repeat;
    }
    for (uint32_t f = 0; f < faces && !g->w.failed; f++) {
        uint32_t a = f / p->columns * across + f % p->columns, d = a + across;
        const uint32_t quad[6] = {a, a + 1, d + 1, a, d + 1, d};
        for (int k = 0; k < 6; k++)
            indices[f * 6 + (uint32_t)k] = quad[k];
    }
    int mesh = 0;
    if (!g->w.failed) {
        int uv =
            p->uv_bits ? glb_normalized(g, uvs, count, 2, p->uv_bits) : glb_doubles(g, uvs, count, 2, false);
        mesh =
            glb_add_mesh(g, &(struct glb_mesh){.name = name,
                                               .positions = glb_doubles(g, positions, count, 3, true) + 1,
                                               .normals = glb_doubles(g, normals, count, 3, false) + 1,
                                               .uvs = uv + 1,
                                               .indices = glb_integers(g, indices, (size_t)faces * 6, 1) + 1,
                                               .material = material});
    }
    free(positions);
    free(normals);
    free(uvs);
    free(indices);
    return mesh;
}

static struct stage_point sphere(double u, double v, const void *radius)
{
    double around = 2.0 * CONTENT_PI * u, up = CONTENT_PI * (v - 0.5);
    struct vec3 n = vec3_make(cos(up) * sin(around), sin(up), cos(up) * cos(around));
    return (struct stage_point){vec3_scale(n, *(const double *)radius), n};
}

int stage_sphere(struct glb *g, const char *name, double radius, int material)
{
    return stage_patch(g, name,
                       &(struct stage_patch){.surface = sphere, .user = &radius, .columns = 32, .rows = 16},
                       material);
}

static struct stage_point plane(double u, double v, const void *size)
{
    const double *s = size;
    return (struct stage_point){vec3_make((u - 0.5) * s[0], (v - 0.5) * s[1], 0), vec3_make(0, 0, 1)};
}

int stage_plane(struct glb *g, const char *name, double width, double height, double repeat, int material)
{
    const double size[2] = {width, height};
    return stage_patch(
        g, name,
        &(struct stage_patch){.surface = plane, .user = size, .columns = 1, .rows = 1, .repeat = repeat},
        material);
}

// Faces with corners of their own, so that normals stay flat.
int stage_box(struct glb *g, const char *name, double x, double y, double z, int material)
{
    struct cage solid = {0}, flat = {0};
    cage_box(&solid, vec3_make(-0.5 * x, -0.5 * y, -0.5 * z), vec3_make(0.5 * x, 0.5 * y, 0.5 * z), 0.0);
    for (size_t i = 0; i < solid.indices.count; i += 4) {
        uint32_t p[4];
        for (size_t k = 0; k < 4; k++)
            p[k] = cage_point(&flat, solid.points.items[solid.indices.items[i + k]]);
        cage_face(&flat, p, 4);
    }
    flat.failed |= solid.failed;
    int mesh = glb_cage_mesh(g, name, &flat, material, 0);
    cage_finish(&solid);
    cage_finish(&flat);
    return mesh;
}

int stage_material(struct glb *g, const char *name, double red, double green, double blue, double roughness)
{
    return glb_add_material(
        g, &(struct glb_material){.name = name, .base_color = {red, green, blue}, .roughness = roughness});
}

int stage_place(struct glb *g, const char *name, int mesh, double x, double y, double z)
{
    return glb_add_node(g, &(struct glb_node){.name = name, .translation = {x, y, z}, .mesh = mesh + 1});
}

// Half the square root of two: quarter turns as quaternions.
static const double quarter = 0.70710678118654752;

void stage_init(struct glb *g)
{
    glb_init(g);
    const double down = -0.5 * atan2(0.8, 5.0);
    glb_add_node(g, &(struct glb_node){.name = "camera",
                                       .translation = {0, 1.5, 5},
                                       .rotation = {sin(down), 0, 0, cos(down)},
                                       .camera = glb_add_camera(g, 0.7, 0.05) + 1});
    int mesh = stage_plane(g, "floor", 8, 8, 8, stage_material(g, "floor", 0.5, 0.5, 0.5, 0.8));
    glb_add_node(
        g, &(struct glb_node){.name = "floor", .rotation = {-quarter, 0, 0, quarter}, .mesh = mesh + 1});
}

void stage_add_wall(struct glb *g)
{
    int wall = stage_plane(g, "wall", 8, 4, 4, stage_material(g, "wall", 0.6, 0.58, 0.55, 0.9));
    stage_place(g, "wall", wall, 0, 2, -3);
}

void stage_add_light(struct glb *g)
{
    int node = glb_add_node(g, &(struct glb_node){.name = "light",
                                                  .translation = {0, 3.5, 1.0},
                                                  .rotation = {-quarter, 0, 0, quarter}});
    cJSON *light = glb_component(g, NG_GLTF_NODES, node, "light_rectangle");
    glb_set(g, light, "radiance", 11.0);
    glb_set_list(g, light, "size", (const double[2]){2, 2}, 2);
}

void stage_add_props(struct glb *g)
{
    int red = stage_material(g, "red", 0.7, 0.12, 0.08, 0.5);
    int white = stage_material(g, "white", 0.75, 0.75, 0.75, 0.7);
    int gold = glb_add_material(
        g, &(struct glb_material){
               .name = "gold", .base_color = {0.95, 0.7, 0.35}, .metallic = 1.0, .roughness = 0.25});
    stage_place(g, "sphere", stage_sphere(g, "sphere", 0.5, gold), 0.0, 0.5, 0.3);
    stage_place(g, "box", stage_box(g, "box", 0.7, 0.7, 0.7, red), -1.2, 0.35, -0.2);
    stage_place(g, "column", stage_box(g, "column", 0.3, 1.6, 0.3, white), 1.1, 0.8, -0.4);
}
