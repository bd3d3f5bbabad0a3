#include "look.h"

#include "picture.h"

#include <string.h>

typedef ng_result (*picture)(struct bytes *out);

struct definition {
    const char *name;
    double color[3]; // linear
    double metallic, roughness;
    picture base, relief, rough, glow;
    double tile[2]; // metres; zero: 1 and 1
    double emissive[3];
    bool double_sided, mask;
};

#define WOOD                                                                                                 \
    .relief = picture_wood_relief, .rough = picture_wood_roughness, .roughness = 1.0, .tile = {0.32, 1.3}
#define CLOTH  .base = picture_weave, .relief = picture_weave_relief, .roughness = 0.92, .tile = {0.085, 0.085}
#define HIDE   .relief = picture_leather_relief, .tile = {0.09, 0.09}
#define LEAVES .color = {1, 1, 1}, .roughness = 0.45, .double_sided = true, .mask = true

static const struct definition definitions[LOOK_COUNT] = {
    [LOOK_OAK] = {"oak", {1, 1, 1}, .base = picture_oak, WOOD},
    [LOOK_WALNUT] = {"walnut", {1, 1, 1}, .base = picture_walnut, WOOD},
    [LOOK_WHITE] = {"white lacquer", {0.80, 0.79, 0.77}, .roughness = 0.35},
    [LOOK_CHARCOAL] = {"charcoal lacquer", {0.035, 0.038, 0.043}, .roughness = 0.4},
    [LOOK_SAGE] = {"sage lacquer", {0.27, 0.33, 0.26}, .roughness = 0.42},
    [LOOK_BLACK_METAL] = {"black metal", {0.022, 0.022, 0.024}, .roughness = 0.42},
    [LOOK_BRASS] = {"brass", {0.83, 0.61, 0.30}, .metallic = 1, .roughness = 0.28},
    [LOOK_STEEL] = {"steel", {0.66, 0.66, 0.67}, .metallic = 1, .roughness = 0.26},
    [LOOK_MIRROR] = {"mirror", {0.93, 0.94, 0.94}, .metallic = 1, .roughness = 0.05},
    [LOOK_PLASTIC] = {"black plastic", {0.030, 0.030, 0.032}, .roughness = 0.55},
    [LOOK_GLASS] = {"black glass", {0.006, 0.006, 0.008}, .roughness = 0.08},
    [LOOK_CERAMIC] = {"white ceramic", {0.80, 0.78, 0.74}, .roughness = 0.14},
    [LOOK_STONEWARE] = {"stoneware", {0.36, 0.33, 0.29}, .roughness = 0.4},
    [LOOK_TERRACOTTA] = {"terracotta", {0.47, 0.19, 0.10}, .roughness = 0.85},
    [LOOK_MARBLE] = {"marble", {1, 1, 1}, .roughness = 0.16, .base = picture_marble, .tile = {0.8, 0.8}},
    [LOOK_PAPER] = {"paper", {0.82, 0.78, 0.68}, .roughness = 0.95},
    [LOOK_SOIL] = {"soil", {0.045, 0.030, 0.020}, .roughness = 1.0},
    [LOOK_BARK] = {"bark", {0.19, 0.125, 0.075}, .roughness = 0.9},
    [LOOK_ORANGE] = {"orange peel",
                     {0.80, 0.28, 0.025},
                     .roughness = 0.42,
                     .relief = picture_leather_relief,
                     .tile = {0.05, 0.05}},
    [LOOK_GREY_CLOTH] = {"grey cloth", {0.36, 0.37, 0.385}, CLOTH},
    [LOOK_SAND_CLOTH] = {"sand cloth", {0.74, 0.63, 0.48}, CLOTH},
    [LOOK_BLUE_CLOTH] = {"blue cloth", {0.060, 0.125, 0.215}, CLOTH},
    [LOOK_RUST_CLOTH] = {"rust cloth", {0.56, 0.175, 0.070}, CLOTH},
    [LOOK_LINEN] = {"linen", {0.86, 0.85, 0.82}, CLOTH},
    [LOOK_VEIL] = {"veil", {0.84, 0.81, 0.75}, CLOTH, .double_sided = true},
    [LOOK_COGNAC_LEATHER] = {"cognac leather", {0.27, 0.095, 0.035}, .roughness = 0.42, HIDE},
    [LOOK_BLACK_LEATHER] = {"black leather", {0.024, 0.023, 0.023}, .roughness = 0.42, HIDE},
    [LOOK_WICKER] = {"wicker",
                     {1, 1, 1},
                     .roughness = 0.7,
                     .base = picture_wicker,
                     .relief = picture_wicker_relief,
                     .tile = {0.16, 0.16}},
    [LOOK_RUG] = {"berber rug", {1, 1, 1}, .roughness = 0.97, .base = picture_rug, .tile = {2.4, 1.7}},
    [LOOK_ROUND_RUG] =
        {"jute rug", {1, 1, 1}, .roughness = 0.95, .base = picture_round_rug, .tile = {1.8, 1.8}},
    [LOOK_SPINES] = {"book cloth", {1, 1, 1}, .roughness = 0.7, .base = picture_spines},
    [LOOK_PRINT_SUN] = {"print of a sun", {1, 1, 1}, .roughness = 0.6, .base = picture_print_sun},
    [LOOK_PRINT_ARCHES] = {"print of arches", {1, 1, 1}, .roughness = 0.6, .base = picture_print_arches},
    [LOOK_PRINT_LEAVES] = {"print of leaves", {1, 1, 1}, .roughness = 0.6, .base = picture_print_leaves},
    [LOOK_CLOCK] = {"clock face", {1, 1, 1}, .roughness = 0.4, .base = picture_clock},
    [LOOK_MONSTERA] = {"monstera leaf", .base = picture_monstera, LEAVES},
    [LOOK_FIDDLE_LEAF] = {"fig leaf", .base = picture_fiddle_leaf, LEAVES},
    [LOOK_FROND] = {"palm frond", .base = picture_frond, LEAVES},
    [LOOK_SHADE] = {"lampshade",
                    {0.75, 0.70, 0.62},
                    .roughness = 0.9,
                    .glow = picture_shade,
                    .emissive = {4.6, 3.5, 2.35},
                    .double_sided = true},
    [LOOK_LANTERN] = {"rice paper",
                      {0.75, 0.72, 0.66},
                      .roughness = 0.9,
                      .glow = picture_lantern,
                      .emissive = {3.6, 2.9, 2.05}},
    [LOOK_PLASTER] = {"plaster",
                      {0.80, 0.78, 0.74},
                      .roughness = 0.92,
                      .relief = picture_plaster_relief,
                      .tile = {0.7, 0.7}},
    [LOOK_CEILING] = {"ceiling", {0.84, 0.83, 0.81}, .roughness = 0.95},
    [LOOK_PARQUET] = {"parquet",
                      {1, 1, 1},
                      .roughness = 1.0,
                      .base = picture_parquet,
                      .relief = picture_parquet_relief,
                      .rough = picture_parquet_roughness,
                      .tile = {0.9, 1.8}},
};

void look_tile(enum look look, double out[2])
{
    const double *tile = definitions[look].tile;
    out[0] = tile[0] > 0.0 ? tile[0] : 1.0;
    out[1] = tile[1] > 0.0 ? tile[1] : 1.0;
}

bool look_tiled(enum look look)
{
    const struct definition *d = &definitions[look];
    return d->base || d->relief || d->rough || d->glow;
}

const char *look_name(enum look look)
{
    return definitions[look].name;
}

int look_texture(struct looks *looks, struct glb *g, picture make)
{
    for (int i = 0; i < looks->texture_count; i++)
        if (looks->textures[i].make == make)
            return looks->textures[i].texture;
    int texture = glb_texture(g, NULL, make, GLB_REPEAT);
    if (looks->texture_count < (int)NG_COUNT(looks->textures)) {
        looks->textures[looks->texture_count].make = make;
        looks->textures[looks->texture_count++].texture = texture;
    }
    return texture;
}

static int texture_of(struct looks *looks, struct glb *g, picture make)
{
    return make ? look_texture(looks, g, make) + 1 : 0;
}

int look_material(struct looks *looks, struct glb *g, enum look look)
{
    const struct definition *d = &definitions[look];
    if (looks->materials[look])
        return looks->materials[look] - 1;
    struct glb_material m = {.name = d->name,
                             .metallic = d->metallic,
                             .roughness = d->roughness,
                             .alpha_cutoff = d->mask ? 0.5 : 0.0,
                             .double_sided = d->double_sided,
                             .base_color_texture = texture_of(looks, g, d->base),
                             .normal_texture = texture_of(looks, g, d->relief),
                             .metallic_roughness_texture = texture_of(looks, g, d->rough),
                             .emissive_texture = texture_of(looks, g, d->glow)};
    memcpy(m.base_color, d->color, sizeof m.base_color);
    memcpy(m.emissive, d->emissive, sizeof m.emissive);
    int index = glb_add_material(g, &m);
    looks->materials[look] = index + 1;
    return index;
}
