#include "furniture.h"

#include "base/hash.h"

#include <stdlib.h>

const double light_warm[3] = {1.0, 0.76, 0.50}, light_soft[3] = {1.0, 0.85, 0.66},
             light_neutral[3] = {1.0, 0.94, 0.86};

void furniture_begin(struct furniture *p, struct glb *g, struct looks *looks, const char *name, int node)
{
    *p = (struct furniture){.g = g, .looks = looks, .name = name, .node = node};
}

struct solid *furniture_part(struct furniture *p, enum look look)
{
    return &p->parts[look];
}

static bool glows(enum look look)
{
    return look == LOOK_SHADE || look == LOOK_LANTERN;
}

static int solid_mesh(struct furniture *p, const struct solid *s, enum look look)
{
    struct glb *g = p->g;
    size_t count = s->vertices.count;
    double *data = calloc(count, 8 * sizeof *data), tile[2];
    int mesh = 0;
    g->w.failed |= s->failed || !data;
    look_tile(look, tile);
    double *positions = data, *normals = data + count * 3, *uvs = data + count * 6;
    for (size_t i = 0; i < count && !g->w.failed; i++) {
        const struct solid_vertex *v = &s->vertices.items[i];
        ((struct vec3 *)positions)[i] = v->position;
        ((struct vec3 *)normals)[i] = v->normal;
        uvs[2 * i] = v->u / tile[0];
        uvs[2 * i + 1] = v->v / tile[1];
    }
    if (!g->w.failed)
        mesh = glb_add_mesh(g, &(struct glb_mesh){
                                   .name = p->name,
                                   .positions = glb_doubles(g, positions, count, 3, true) + 1,
                                   .normals = glb_doubles(g, normals, count, 3, false) + 1,
                                   .uvs = look_tiled(look) ? glb_doubles(g, uvs, count, 2, false) + 1 : 0,
                                   .indices = glb_integers(g, s->indices.items, s->indices.count, 1) + 1,
                                   .material = look_material(p->looks, g, look),
                               });
    free(data);
    return mesh;
}

void furniture_end(struct furniture *p)
{
    for (int look = 0; look < LOOK_COUNT; look++) {
        struct solid *s = &p->parts[look];
        if (s->indices.count) {
            int mesh = solid_mesh(p, s, (enum look)look);
            int node = glb_add_node(p->g, &(struct glb_node){.name = look_name((enum look)look),
                                                             .parent = p->node + 1,
                                                             .mesh = mesh + 1});
            if (glows((enum look)look))
                glb_set(p->g, glb_component(p->g, NG_GLTF_NODES, node, "light_mesh"), "scale", 1.0);
        }
        p->g->w.failed |= s->failed;
        solid_finish(s);
    }
}

static int add_cage(struct furniture *p, const char *name, struct cage *cage, enum look look)
{
    double tile[2];
    look_tile(look, tile);
    for (size_t i = 0; i < cage->uvs.count; i++) {
        cage->uvs.items[i].u /= tile[0];
        cage->uvs.items[i].v /= tile[1];
    }
    return glb_cage_mesh(p->g, name, cage, look_material(p->looks, p->g, look), 2);
}

static int cage_mesh(struct furniture *p, const char *name, struct cage *cage, enum look look)
{
    uint64_t hash =
        ng_hash_bytes((uint64_t)look, cage->points.items, cage->points.count * sizeof *cage->points.items);
    for (int i = 0; i < p->mesh_count; i++)
        if (p->meshes[i].hash == hash)
            return p->meshes[i].mesh;
    int mesh = add_cage(p, name, cage, look);
    if (p->mesh_count < (int)NG_COUNT(p->meshes)) {
        p->meshes[p->mesh_count].hash = hash;
        p->meshes[p->mesh_count++].mesh = mesh;
    }
    return mesh;
}

static struct glb_node node_at(struct furniture *p, const char *name, const struct place *at)
{
    struct glb_node n = {.name = name, .parent = p->node + 1, .translation = {at->at.x, at->at.y, at->at.z}};
    place_quaternion(at, n.rotation);
    if (fabs(n.rotation[3]) > 1.0 - 1e-12)
        n.rotation[3] = 0.0;
    return n;
}

void furniture_soft(struct furniture *p, const char *name, struct cage *cage, enum look look, struct place at)
{
    struct glb_node n = node_at(p, name, &at);
    n.mesh = cage_mesh(p, name, cage, look) + 1;
    glb_add_node(p->g, &n);
    cage_finish(cage);
    *cage = (struct cage){0};
}

cJSON *furniture_light(struct furniture *p, const char *component, struct place at, const double color[3])
{
    struct glb_node n = node_at(p, "light", &at);
    cJSON *light = glb_component(p->g, NG_GLTF_NODES, glb_add_node(p->g, &n), component);
    glb_set_list(p->g, light, "color", color, 3);
    return light;
}

void furniture_spot(struct furniture *p, struct place at, const double color[3], double intensity,
                    double inner, double outer)
{
    struct glb_node n = node_at(p, "light", &at);
    n.light = glb_add_light(p->g, "spot", "spot", color, intensity, inner, outer) + 1;
    glb_add_node(p->g, &n);
}

// ---- shapes that many pieces have ----

void slab(struct solid *s, double x, double y, double z, double w, double h, double d, double corner)
{
    double a = 0.5 * w, b = 0.5 * d;
    const struct solid_corner outline[4] = {
        {-a, -b, corner}, {a, -b, corner}, {a, b, corner}, {-a, b, corner}};
    solid_extrude(s, place_turn(place_at(x, y + 0.5 * h, z), 'x', -QUARTER), outline, 4, h);
}

void ring(struct solid *s, double x, double y, double z, double radius, double thick)
{
    enum { BENDS = 24 };
    struct solid_bend way[BENDS + 1];
    for (int i = 0; i <= BENDS; i++) {
        double angle = 2.0 * CONTENT_PI * i / BENDS;
        way[i] = (struct solid_bend){radius * sin(angle), 0.0, radius * cos(angle), 0.0};
    }
    solid_tube(s, place_at(x, y, z), way, BENDS + 1, thick, thick, thick < 0.004 ? 6 : 10);
}

void picture_plane(struct solid *s, struct place p, double w, double h)
{
    uint32_t first = 0;
    for (int i = 0; i < 4; i++) {
        double u = i == 1 || i == 2, v = i >= 2;
        uint32_t at =
            solid_vertex(s, &p, vec3_make((u - 0.5) * w, (v - 0.5) * h, 0), vec3_make(0, 0, 1), u, 1 - v);
        first = i ? first : at;
    }
    solid_quad(s, first, first + 1, first + 2, first + 3);
}
