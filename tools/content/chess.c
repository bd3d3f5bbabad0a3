// The chess scene: a closed room after the Cornell box, two area lights, a board turned towards the camera so
// that both armies show their profiles, and the dance of choreography.h. Metres.
//
//   room    0.86 wide, 0.47 high, from z = -0.41 to 1.3; the camera stands inside, so no picture sees an edge
//   board   0.54 square, 24 mm high, squares of 60 mm
#include "choreography.h"
#include "content.h"
#include "glb.h"
#include "texture.h"
#include "unseen.h"
#include "vary.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SQUARE     0.06
#define BOARD_TOP  0.026
#define BOARD_TURN (-0.36) // radians about Y: files run from left to right, light pieces on the left
#define ROOM_X     0.43
#define ROOM_Y     0.47
#define ROOM_BACK  (-0.41)
#define ROOM_FRONT 1.3

enum troupe { TROUPE_PIECES, TROUPE_KNOTS, TROUPE_FIGURES };

// What differs from Chess; zero: nothing.
struct plan {
    enum troupe troupe; // who dances; figures: in place of the light pieces
    double wall_moved;  // the right one, outwards
    bool third_light, flight;
};

struct chess {
    struct glb glb;
    struct plan plan;
    int wood_light, wood_dark, frame, ivory, ebony;         // materials
    int room[6];                                            // materials of the walls, floor and ceiling
    int board, lights[3], rigs[3], camera, pieces[DANCERS]; // nodes
};

// ---- the room ----

// One wall: four corners counter-clockwise as seen from inside.
static int add_wall(struct glb *g, const char *name, const struct glb_material *look,
                    const double corners[4][3])
{
    struct cage c = {0};
    for (int i = 0; i < 4; i++)
        cage_point(&c, vec3_make(corners[i][0], corners[i][1], corners[i][2]));
    cage_quad(&c, 0, 1, 2, 3);
    int material = glb_add_material(g, look);
    glb_add_node(g, &(struct glb_node){.name = name, .mesh = glb_cage_mesh(g, name, &c, material, 0) + 1});
    cage_finish(&c);
    return material;
}

static void add_room(struct chess *s)
{
    struct glb *g = &s->glb;
    int *room = s->room;
    const double x = ROOM_X, r = x + s->plan.wall_moved, y = ROOM_Y, b = ROOM_BACK, f = ROOM_FRONT;
    const struct glb_material left = {
        .name = "wall-left", .base_color = {0.63, 0.11, 0.055}, .roughness = 0.9};
    const struct glb_material right = {
        .name = "wall-right", .base_color = {0.05, 0.26, 0.30}, .roughness = 0.9};
    const struct glb_material back = {
        .name = "wall-back", .base_color = {0.73, 0.70, 0.66}, .roughness = 0.9};
    const struct glb_material front = {
        .name = "wall-front", .base_color = {0.60, 0.58, 0.55}, .roughness = 0.9};
    const struct glb_material floor = {.name = "floor", .base_color = {0.62, 0.58, 0.53}, .roughness = 0.45};
    const struct glb_material ceiling = {
        .name = "ceiling", .base_color = {0.76, 0.75, 0.73}, .roughness = 0.9};
    room[0] =
        add_wall(g, "wall-left", &left, (const double[4][3]){{-x, 0, f}, {-x, 0, b}, {-x, y, b}, {-x, y, f}});
    room[1] =
        add_wall(g, "wall-right", &right, (const double[4][3]){{r, 0, b}, {r, 0, f}, {r, y, f}, {r, y, b}});
    room[2] =
        add_wall(g, "wall-back", &back, (const double[4][3]){{-x, 0, b}, {r, 0, b}, {r, y, b}, {-x, y, b}});
    room[3] =
        add_wall(g, "wall-front", &front, (const double[4][3]){{r, 0, f}, {-x, 0, f}, {-x, y, f}, {r, y, f}});
    room[4] =
        add_wall(g, "floor", &floor, (const double[4][3]){{-x, 0, f}, {r, 0, f}, {r, 0, b}, {-x, 0, b}});
    room[5] =
        add_wall(g, "ceiling", &ceiling, (const double[4][3]){{-x, y, b}, {r, y, b}, {r, y, f}, {-x, y, f}});
}

// ---- the board ----

// All 32 squares of one colour: each a low tile with bevelled rim, its grain shifted so that no two match.
static void add_squares(struct chess *s, bool dark, int material)
{
    enum { TILES = 32 };
    static const double inset = 0.0011, depth = 0.0009;
    NG_ARRAY(double) positions = {0};
    NG_ARRAY(double) uvs = {0};
    NG_ARRAY(uint32_t) indices = {0};
    bool ok = ng_array_resize(&positions, TILES * 8 * 3) && ng_array_resize(&uvs, TILES * 8 * 2) &&
              ng_array_resize(&indices, TILES * 30);
    s->glb.w.failed |= !ok;
    double *p = positions.items, *uv = uvs.items;
    uint32_t *index = indices.items, tile = 0;
    for (int square = 0; ok && square < 64; square++) {
        int file = square % 8, rank = square / 8;
        if (((file + rank) % 2 == 0) != dark)
            continue;
        double shift_u = 0.37 * file + 0.11 * rank, shift_v = 0.23 * rank + 0.61 * file;
        for (int k = 0; k < 8; k++) {
            static const double sides[4][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}};
            double half = 0.5 * SQUARE - (k < 4 ? 0.0 : inset);
            double dx = sides[k % 4][0] * half, dz = sides[k % 4][1] * half;
            *p++ = (file - 3.5) * SQUARE + dx;
            *p++ = BOARD_TOP - (k < 4 ? depth : 0.0);
            *p++ = (3.5 - rank) * SQUARE + dz;
            *uv++ = shift_u + dx / 0.24;
            *uv++ = shift_v + dz / 0.24;
        }
        static const uint32_t quads[5][4] = {
            {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
        for (int q = 0; q < 5; q++)
            for (int k = 0; k < 6; k++)
                *index++ = tile * 8 + quads[q][(const int[6]){0, 1, 2, 0, 2, 3}[k]];
        tile++;
    }
    if (ok) {
        const char *name = dark ? "squares-dark" : "squares-light";
        int mesh = glb_add_mesh(
            &s->glb, &(struct glb_mesh){
                         .name = name,
                         .positions = glb_doubles(&s->glb, positions.items, TILES * 8, 3, true) + 1,
                         .uvs = glb_doubles(&s->glb, uvs.items, TILES * 8, 2, false) + 1,
                         .indices = glb_integers(&s->glb, indices.items, TILES * 30, 1) + 1,
                         .material = material,
                     });
        glb_add_node(&s->glb, &(struct glb_node){.name = name, .parent = s->board + 1, .mesh = mesh + 1});
    }
    ng_array_finish(&positions);
    ng_array_finish(&uvs);
    ng_array_finish(&indices);
}

// A square moulding around the playing field: an outline swept around the board as a cage.
static void add_frame(struct chess *s)
{
    static const double outline[][3] = {
        // distance from the centre, height, sharpness
        {0.2400, 0.0000, 5},   {0.2400, 0.0272, 3}, {0.2416, 0.0284, 2.5}, {0.2560, 0.0284, 2},
        {0.2590, 0.0262, 1.5}, {0.2680, 0.0240, 2}, {0.2700, 0.0215, 2.5}, {0.2700, 0.0060, 2.5},
        {0.2740, 0.0050, 2.5}, {0.2740, 0.0000, 5},
    };
    enum { N = 4 };
    struct cage c = {0};
    const uint32_t rings = (uint32_t)NG_COUNT(outline);
    static const double sides[N][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}};
    for (uint32_t r = 0; r < rings; r++)
        for (int i = 0; i < N; i++)
            cage_point(&c,
                       vec3_make(sides[i][0] * outline[r][0], outline[r][1], sides[i][1] * outline[r][0]));
    for (uint32_t r = 0; r < rings; r++) {
        uint32_t next = (r + 1) % rings;
        cage_bridge(&c, N, next * N, r * N);
        cage_crease_ring(&c, N, r * N, outline[r][2]);
        for (uint32_t i = 0; i < N; i++)
            cage_add_crease(&c, r * N + i, next * N + i, 4);
    }
    int mesh = glb_cage_mesh(&s->glb, "frame", &c, s->frame, 3);
    glb_add_node(&s->glb, &(struct glb_node){.name = "frame", .parent = s->board + 1, .mesh = mesh + 1});
    cage_finish(&c);
}

static void add_board(struct chess *s)
{
    int light_texture = glb_texture(&s->glb, "maple", texture_maple, GLB_REPEAT) + 1;
    int dark_texture = glb_texture(&s->glb, "walnut", texture_walnut, GLB_REPEAT) + 1;
    s->wood_light = glb_add_material(&s->glb, &(struct glb_material){.name = "square-light",
                                                                     .base_color = {1, 1, 1},
                                                                     .roughness = 0.22,
                                                                     .base_color_texture = light_texture});
    s->wood_dark = glb_add_material(&s->glb, &(struct glb_material){.name = "square-dark",
                                                                    .base_color = {1, 1, 1},
                                                                    .roughness = 0.22,
                                                                    .base_color_texture = dark_texture});
    s->frame = glb_add_material(
        &s->glb,
        &(struct glb_material){.name = "frame", .base_color = {0.075, 0.034, 0.018}, .roughness = 0.2});
    s->board = glb_add_node(&s->glb,
                            &(struct glb_node){.name = "board",
                                               .translation = {0.03, 0, 0},
                                               .rotation = {0, sin(0.5 * (BOARD_TURN - 0.5 * CONTENT_PI)), 0,
                                                            cos(0.5 * (BOARD_TURN - 0.5 * CONTENT_PI))}});
    add_squares(s, false, s->wood_light);
    add_squares(s, true, s->wood_dark);
    add_frame(s);
}

// ---- the pieces ----

static struct vec3 on_board(struct vec3 at)
{
    return vec3_make((at.x - 3.5) * SQUARE, BOARD_TOP + at.y, (3.5 - at.z) * SQUARE);
}

// Keys of a dancer: cubic with flat ends is the ease of dance_at; a hop has a key at its top.
static void add_dance(struct glb *g, int animation, int node, const struct dancer *d)
{
    enum { MOST = 8 };
    double times[MOST], values[MOST][3][3] = {0};
    size_t keys = 0;
    for (int way = 0; way < 2; way++)
        for (int stop = 0; stop < 3; stop++) {
            if (stop == 1 && d->lift == 0.0)
                continue;
            double t = d->start + 0.5 * d->duration * stop;
            t = way ? DANCE_SECONDS - (d->start + 0.5 * d->duration * (2 - stop)) : t;
            struct vec3 p = on_board(dance_at(d, t));
            if (stop == 1) { // the slope of smoothstep at its middle
                struct vec3 a = on_board(vec3_make(d->from[0], 0, d->from[1])),
                            b = on_board(vec3_make(d->to[0], 0, d->to[1]));
                struct vec3 slope = vec3_scale(vec3_sub(b, a), (way ? -1.5 : 1.5) / d->duration);
                for (int side = 0; side < 3; side += 2) {
                    values[keys][side][0] = slope.x;
                    values[keys][side][2] = slope.z;
                }
            }
            times[keys] = t;
            values[keys][1][0] = p.x;
            values[keys][1][1] = p.y;
            values[keys++][1][2] = p.z;
        }
    glb_add_channel(g, animation,
                    &(struct glb_channel){.node = node,
                                          .path = "translation",
                                          .interpolation = "CUBICSPLINE",
                                          .times = times,
                                          .values = &values[0][0][0],
                                          .keys = keys});
}

static void add_pieces(struct chess *s, int animation)
{
    const int materials[2] = {s->ivory, s->ebony};
    const bool figures = s->plan.troupe == TROUPE_FIGURES;
    const struct figure figure = figures ? figure_init(&s->glb, s->ivory) : (struct figure){0};
    const int walk = figures ? glb_add_animation(&s->glb, "walk") : GLB_NONE;
    void (*const build)(enum piece, struct cage *) =
        s->plan.troupe == TROUPE_KNOTS ? knot_build : piece_build;
    int meshes[2][PIECE_KINDS];
    for (int side = 0; side < 2; side++)
        for (int kind = 0; kind < PIECE_KINDS; kind++) {
            struct cage c = {0};
            char name[32];
            build((enum piece)kind, &c);
            snprintf(name, sizeof name, "%s-%s", side ? "dark" : "light", piece_name((enum piece)kind));
            meshes[side][kind] = glb_cage_mesh(&s->glb, name, &c, materials[side], CHESS_PIECE_LEVEL);
            cage_finish(&c);
        }
    for (int i = 0; i < DANCERS; i++) {
        struct dancer d = dance_get(i);
        struct vec3 at = on_board(dance_at(&d, 0.0));
        char name[48];
        snprintf(name, sizeof name, "%s-%s-%c%d", d.dark ? "dark" : "light", piece_name(d.kind),
                 'a' + d.from[0], d.from[1] + 1);
        const bool walks = figures && !d.dark;
        // Light pieces look along their files, away from their own side: towards -Z of the board.
        int node = glb_add_node(&s->glb,
                                &(struct glb_node){.name = name,
                                                   .parent = s->board + 1,
                                                   .translation = {at.x, at.y, at.z},
                                                   .rotation = {0, d.dark ? 0.0 : 1.0, 0, d.dark ? 1.0 : 0.0},
                                                   .mesh = walks ? 0 : meshes[d.dark][d.kind] + 1});
        if (walks)
            figure_add(&s->glb, &figure, name, node + 1, piece_height(d.kind) / FIGURE_HEIGHT, walk);
        add_dance(&s->glb, animation, node, &d);
        s->pieces[i] = node;
    }
}

// ---- lights and camera ----

// A light that drifts around an ellipse: four cubic keys a loop, tangents along the ellipse. It hangs on a
// rig, which can be moved while the clip moves the light.
static void add_light(struct chess *s, int index, int animation, const char *name, const double rotation[4],
                      struct vec3 center, struct vec3 cosine, struct vec3 sine, const double size[2],
                      const double color[3], double radiance)
{
    enum { KEYS = 9 };
    double times[KEYS], values[KEYS][3][3];
    for (int k = 0; k < KEYS; k++) {
        double angle = 2.0 * CONTENT_PI * k / (KEYS - 1), speed = 2.0 * CONTENT_PI / DANCE_SECONDS;
        struct vec3 p =
            vec3_add(center, vec3_add(vec3_scale(cosine, cos(angle)), vec3_scale(sine, sin(angle))));
        struct vec3 v =
            vec3_scale(vec3_sub(vec3_scale(sine, cos(angle)), vec3_scale(cosine, sin(angle))), speed);
        times[k] = DANCE_SECONDS * k / (KEYS - 1);
        for (int part = 0; part < 3; part++) {
            const struct vec3 *from = part == 1 ? &p : &v;
            values[k][part][0] = from->x;
            values[k][part][1] = from->y;
            values[k][part][2] = from->z;
        }
    }
    char rig[32];
    snprintf(rig, sizeof rig, "%s-rig", name);
    s->rigs[index] = glb_add_node(&s->glb, &(struct glb_node){.name = rig});
    int node = glb_add_node(
        &s->glb, &(struct glb_node){.name = name,
                                    .parent = s->rigs[index] + 1,
                                    .translation = {values[0][1][0], values[0][1][1], values[0][1][2]},
                                    .rotation = {rotation[0], rotation[1], rotation[2], rotation[3]}});
    s->lights[index] = node;
    cJSON *light = glb_component(&s->glb, NG_GLTF_NODES, node, "light_rectangle");
    glb_set_list(&s->glb, light, "color", color, 3);
    glb_set(&s->glb, light, "radiance", radiance);
    glb_set_list(&s->glb, light, "size", size, 2);
    glb_add_channel(&s->glb, animation,
                    &(struct glb_channel){.node = node,
                                          .path = "translation",
                                          .interpolation = "CUBICSPLINE",
                                          .times = times,
                                          .values = &values[0][0][0],
                                          .keys = KEYS});
}

static void add_lights(struct chess *s, int animation)
{
    const double half = 0.70710678118654752;
    add_light(s, 0, animation, "light-ceiling", (const double[4]){-half, 0, 0, half},
              vec3_make(0, ROOM_Y - 0.004, 0.02), vec3_make(-0.10, 0, 0), vec3_make(0, 0, 0.10),
              (const double[2]){0.32, 0.22}, (const double[3]){1.0, 0.97, 0.93}, 7.8);
    add_light(s, 1, animation, "light-back", (const double[4]){0, 1, 0, 0},
              vec3_make(0.02, 0.27, ROOM_BACK + 0.004), vec3_make(0.17, 0, 0), vec3_make(0, 0.04, 0),
              (const double[2]){0.24, 0.14}, (const double[3]){1.0, 0.64, 0.28}, 2.4);
    if (s->plan.third_light)
        add_light(s, 2, animation, "light-left", (const double[4]){0, -half, 0, half},
                  vec3_make(0.004 - ROOM_X, 0.26, 0.1), vec3_make(0, 0, 0.14), vec3_make(0, 0.05, 0),
                  (const double[2]){0.22, 0.16}, (const double[3]){0.35, 0.6, 1.0}, 4.0);
}

// Around the board's front and up and down; looks at its middle.
static void add_flight(struct glb *g, int animation, int camera)
{
    enum { KEYS = 41 };
    const struct vec3 target = vec3_make(0, 0.05, 0);
    double times[KEYS], places[KEYS][3], turns[KEYS][4];
    for (int k = 0; k < KEYS; k++) {
        double phase = 2.0 * CONTENT_PI * k / (KEYS - 1);
        struct vec3 eye = vec3_make(0.3 * sin(phase), 0.27 + 0.09 * cos(phase), 0.78 + 0.14 * cos(phase));
        struct vec3 look = vec3_sub(target, eye);
        double turn = 0.5 * atan2(-look.x, -look.z), tilt = 0.5 * atan2(look.y, hypot(look.x, look.z));
        times[k] = DANCE_SECONDS * k / (KEYS - 1);
        memcpy(places[k], &eye, sizeof places[k]);
        turns[k][0] = cos(turn) * sin(tilt);
        turns[k][1] = sin(turn) * cos(tilt);
        turns[k][2] = -sin(turn) * sin(tilt);
        turns[k][3] = cos(turn) * cos(tilt);
    }
    struct glb_channel channel = {
        .node = camera, .path = "translation", .interpolation = "LINEAR", .times = times, .keys = KEYS};
    channel.values = places[0];
    glb_add_channel(g, animation, &channel);
    channel.path = "rotation";
    channel.values = turns[0];
    glb_add_channel(g, animation, &channel);
}

static int add_view(struct glb *g, double wall_moved)
{
    // 14 degrees down from the middle of the room's front.
    const double tilt = -0.25;
    int camera = glb_add_node(g, &(struct glb_node){.name = "camera",
                                                    .translation = {0.0, 0.385, 0.95},
                                                    .rotation = {sin(0.5 * tilt), 0, 0, cos(0.5 * tilt)},
                                                    .camera = glb_add_camera(g, 0.77, 0.01) + 1});
    cJSON *scale = glb_component(g, NG_GLTF_SCENES, 0, "scene_scale");
    const double center[3] = {0.5 * wall_moved, 0.5 * ROOM_Y, 0.5 * (ROOM_BACK + ROOM_FRONT)};
    double half[3] = {ROOM_X + 0.5 * wall_moved, 0.5 * ROOM_Y, 0.5 * (ROOM_FRONT - ROOM_BACK)};
    glb_set_list(g, scale, "center", center, 3);
    glb_set(g, scale, "radius", sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]));
    return camera;
}

// ---- what may vary ----

// The walls are no obstacle to lights: a ceiling lamp hangs low enough to be turned.
static void vary_lights(struct chess *s, int group)
{
    static const double white[][4] = {{1, 0.97, 0.93}, {1, 0.86, 0.66}, {0.8, 0.9, 1}, {1, 1, 1}};
    static const double colors[][4] = {
        {1, 0.64, 0.28}, {0.3, 0.55, 1}, {1, 0.35, 0.3}, {0.45, 1, 0.5}, {1, 1, 1}};
    const struct vary list[] = {
        {.name = "vary-ceiling-place",
         .field = "transform.translation",
         .kind = "offset",
         .node = s->rigs[0] + 1,
         .min = {-0.1, -0.1, -0.1},
         .max = {0.1, -0.04, 0.2}},
        {.name = "vary-ceiling-turn",
         .field = "transform.rotation",
         .kind = "turn",
         .node = s->lights[0] + 1,
         .min = {-0.2, -0.1},
         .max = {0.2, 0.1}},
        {.name = "vary-ceiling-size",
         .field = "light_rectangle.size",
         .kind = "range",
         .node = s->lights[0] + 1,
         .min = {0.1, 0.08},
         .max = {0.36, 0.3}},
        {.name = "vary-ceiling-power",
         .field = "light_rectangle.radiance",
         .kind = "log_range",
         .node = s->lights[0] + 1,
         .min = {2.5},
         .max = {16}},
        {.name = "vary-ceiling-color",
         .field = "light_rectangle.color",
         .kind = "choices",
         .node = s->lights[0] + 1,
         .choices = white,
         .choice_count = NG_COUNT(white)},
        {.name = "vary-back-place",
         .field = "transform.translation",
         .kind = "offset",
         .node = s->rigs[1] + 1,
         .min = {-0.1, -0.03, 0.03},
         .max = {0.1, 0.06, 0.06}},
        {.name = "vary-back-turn",
         .field = "transform.rotation",
         .kind = "turn",
         .node = s->lights[1] + 1,
         .min = {-0.25, -0.25},
         .max = {0.25, 0.25}},
        {.name = "vary-back-size",
         .field = "light_rectangle.size",
         .kind = "range",
         .node = s->lights[1] + 1,
         .min = {0.08, 0.06},
         .max = {0.2, 0.18}},
        {.name = "vary-back-power",
         .field = "light_rectangle.radiance",
         .kind = "log_range",
         .node = s->lights[1] + 1,
         .min = {1},
         .max = {10}},
        {.name = "vary-back-color",
         .field = "light_rectangle.color",
         .kind = "choices",
         .node = s->lights[1] + 1,
         .choices = colors,
         .choice_count = NG_COUNT(colors)},
    };
    for (size_t i = 0; i < NG_COUNT(list); i++)
        vary_add(&s->glb, group, &list[i]);
}

static void vary_color(struct chess *s, int group, const char *name, int material, double min, double max)
{
    vary_add(&s->glb, group,
             &(struct vary){.name = name,
                            .field = "material.base_color",
                            .kind = "range",
                            .material = material + 1,
                            .min = {min, min, min},
                            .max = {max, max, max}});
}

static void vary_number(struct chess *s, int group, const char *name, const char *field, int material,
                        double min, double max)
{
    vary_add(&s->glb, group,
             &(struct vary){.name = name,
                            .field = field,
                            .kind = "range",
                            .material = material + 1,
                            .min = {min},
                            .max = {max}});
}

static void vary_metal(struct chess *s, int group, const char *name, int material)
{
    static const double metal[][4] = {{0}, {1}};
    vary_add(&s->glb, group,
             &(struct vary){.name = name,
                            .field = "material.metallic",
                            .kind = "choices",
                            .material = material + 1,
                            .choices = metal,
                            .choice_count = NG_COUNT(metal)});
}

static void vary_materials(struct chess *s, int group)
{
    static const char *const walls[] = {"vary-wall-left",  "vary-wall-right", "vary-wall-back",
                                        "vary-wall-front", "vary-floor",      "vary-ceiling"};
    for (int i = 0; i < 6; i++)
        vary_color(s, group, walls[i], s->room[i], 0.04, 0.8);
    vary_color(s, group, "vary-light-pieces", s->ivory, 0.3, 0.95);
    vary_color(s, group, "vary-dark-pieces", s->ebony, 0.03, 0.6);
    vary_metal(s, group, "vary-light-metal", s->ivory);
    vary_metal(s, group, "vary-dark-metal", s->ebony);
    const char *roughness = "material.roughness";
    vary_number(s, group, "vary-rough-floor", roughness, s->room[4], 0.15, 0.9);
    vary_number(s, group, "vary-rough-light-squares", roughness, s->wood_light, 0.1, 0.5);
    vary_number(s, group, "vary-rough-dark-squares", roughness, s->wood_dark, 0.1, 0.5);
    vary_number(s, group, "vary-rough-frame", roughness, s->frame, 0.1, 0.5);
    vary_number(s, group, "vary-rough-light-pieces", roughness, s->ivory, 0.1, 0.6);
    vary_number(s, group, "vary-rough-dark-pieces", roughness, s->ebony, 0.1, 0.6);
}

// The clip says where pieces stand; they may turn and stretch besides, and all of them with the board.
static void vary_things(struct chess *s, int group)
{
    vary_add(&s->glb, group, &(struct vary){.name = "vary-time", .kind = "time", .max = {DANCE_SECONDS}});
    vary_add(&s->glb, group,
             &(struct vary){.name = "vary-board",
                            .field = "transform.rotation",
                            .kind = "turn",
                            .node = s->board + 1,
                            .min = {0, -3.14},
                            .max = {0, 3.14}});
    for (int i = 0; i < DANCERS; i++) {
        char turn[24], stretch[32];
        snprintf(turn, sizeof turn, "vary-turn-%d", i);
        snprintf(stretch, sizeof stretch, "vary-stretch-%d", i);
        vary_add(&s->glb, group,
                 &(struct vary){.name = turn,
                                .field = "transform.rotation",
                                .kind = "turn",
                                .node = s->pieces[i] + 1,
                                .min = {0, -3.14},
                                .max = {0, 3.14}});
        vary_add(&s->glb, group,
                 &(struct vary){.name = stretch,
                                .field = "transform.scale",
                                .kind = "range",
                                .node = s->pieces[i] + 1,
                                .min = {0.85, 0.8, 0.85},
                                .max = {1.15, 1.35, 1.15}});
    }
}

static void vary_view(struct chess *s, int group)
{
    vary_add(&s->glb, group,
             &(struct vary){.name = "vary-view",
                            .kind = "camera",
                            .node = s->camera + 1,
                            .min = {-0.38, 0.08, 0.3},
                            .max = {0.38, 0.43, 1.1},
                            .look_min = {-0.2, 0, -0.2},
                            .look_max = {0.2, 0.15, 0.2}});
    vary_add(&s->glb, group,
             &(struct vary){.name = "vary-lens",
                            .field = "camera.fov_y",
                            .kind = "range",
                            .node = s->camera + 1,
                            .min = {0.5},
                            .max = {0.95}});
}

static ng_result build(const struct plan *plan, struct bytes *out)
{
    struct chess s = {.plan = *plan};
    glb_init(&s.glb);
    s.camera = add_view(&s.glb, plan->wall_moved);
    add_room(&s);
    add_board(&s);
    s.ivory = glb_add_material(
        &s.glb,
        &(struct glb_material){.name = "piece-light", .base_color = {0.86, 0.77, 0.60}, .roughness = 0.16});
    s.ebony = glb_add_material(&s.glb, &(struct glb_material){.name = "piece-dark",
                                                              .base_color = {0.30, 0.27, 0.25},
                                                              .metallic = 1.0,
                                                              .roughness = 0.18});
    int animation = glb_add_animation(&s.glb, "dance");
    add_lights(&s, animation);
    add_pieces(&s, animation);
    if (plan->flight)
        add_flight(&s.glb, animation, s.camera);
    int group = glb_add_node(&s.glb, &(struct glb_node){.name = "variations"}) + 1;
    vary_lights(&s, group);
    vary_materials(&s, group);
    vary_things(&s, group);
    vary_view(&s, group);
    return glb_finish(&s.glb, out);
}

ng_result chess_build(struct bytes *out)
{
    return build(&(struct plan){0}, out);
}

ng_result chess_flight(struct bytes *out)
{
    return build(&(struct plan){.flight = true}, out);
}

ng_result unseen_knots(struct bytes *out)
{
    return build(&(struct plan){.troupe = TROUPE_KNOTS}, out);
}

ng_result unseen_figures(struct bytes *out)
{
    return build(&(struct plan){.troupe = TROUPE_FIGURES}, out);
}

ng_result unseen_lights(struct bytes *out)
{
    return build(&(struct plan){.third_light = true}, out);
}

ng_result unseen_wall(struct bytes *out)
{
    return build(&(struct plan){.wall_moved = 0.3}, out);
}
