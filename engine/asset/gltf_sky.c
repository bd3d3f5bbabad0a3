// The light of a file that has none: a sky as it is in a photographer's studio, whose lamps are large and
// soft. Metals have something to show in it, things have a light and a dark side, and nothing is in full
// darkness.
#include "asset/gltf_loader_internal.h"
#include "asset/image_internal.h"
#include "base/log.h"
#include "components/components.h"
#include "components/light_directional.h"
#include "components/light_environment.h"
#include "components/light_point.h"
#include "components/light_spot.h"
#include "components/transform.h"

#include <math.h>
#include <string.h>

// Lamps are wider than some texels, so that this few do.
#define WIDTH  128
#define HEIGHT 64
#define PI     3.14159265f

// A soft box on the sky: a rounded rectangle of angles, whose edges fade out.
struct lamp {
    float azimuth, elevation;      // radians; azimuth 0 is +Z, pi / 2 is +X
    float half_width, half_height; // radians
    float edge;                    // in which it fades, radians
    float radiance[3];
};

static const struct lamp lamps[] = {
    {-0.70f, 0.85f, 0.32f, 0.24f, 0.25f, {4.40f, 4.25f, 4.00f}},    // key: front left, above
    {1.45f, 0.45f, 0.26f, 0.38f, 0.30f, {0.55f, 0.60f, 0.68f}},     // fill: right, cooler
    {PI - 0.4f, 0.80f, 0.45f, 0.14f, 0.25f, {1.05f, 1.05f, 1.10f}}, // rim: behind, above
};

static float smooth(float from, float to, float x)
{
    float t = fminf(fmaxf((x - from) / (to - from), 0), 1);
    return t * t * (3 - 2 * t);
}

// How much of a lamp there is in a direction, 0 to 1.
static float coverage(const struct lamp *lamp, float azimuth, float elevation)
{
    float x = remainderf(azimuth - lamp->azimuth, 2 * PI) * cosf(elevation), y = elevation - lamp->elevation;
    x = fmaxf(fabsf(x) - lamp->half_width, 0);
    y = fmaxf(fabsf(y) - lamp->half_height, 0);
    return 1 - smooth(0, lamp->edge, sqrtf(x * x + y * y));
}

// A dome that is brighter above than at the horizon, on a floor that is darker towards the feet.
static void radiance_at(float azimuth, float elevation, float out[3])
{
    static const float zenith[3] = {0.16f, 0.16f, 0.17f}, horizon[3] = {0.17f, 0.17f, 0.175f},
                       nadir[3] = {0.09f, 0.088f, 0.085f};
    float up = smooth(0, PI / 2, elevation), down = smooth(0, PI / 2, -elevation);
    for (int i = 0; i < 3; i++) {
        out[i] = horizon[i] + (zenith[i] - horizon[i]) * up + (nadir[i] - horizon[i]) * down;
        for (size_t k = 0; k < NG_COUNT(lamps); k++)
            out[i] += lamps[k].radiance[i] * coverage(&lamps[k], azimuth, elevation);
    }
}

// Map centre looks along -Z, x grows to the right of it; row 0 is +Y (components/light_environment.h).
static void paint(struct ng_image *image)
{
    float *texel = image->pixels;
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++, texel += 4) {
            float turn = 2 * PI * (((float)x + 0.5f) / WIDTH - 0.5f);
            radiance_at(PI - turn, PI * (0.5f - ((float)y + 0.5f) / HEIGHT), texel);
            texel[3] = 1;
        }
}

static ng_result make_map(struct gltf_loader *l, ng_asset *out)
{
    const struct ng_image_params params = {.sampling.wrap_u = NG_WRAP_REPEAT};
    struct ng_image image;
    NG_TRY(ng_gltf_budget(l, (uint64_t)WIDTH * HEIGHT * 4 * sizeof(float) * 4 / 3, "the default sky"));
    NG_TRY(ng_image_allocate("the default sky", WIDTH, HEIGHT, NG_PIXEL_RGBA32F, &params, &image));
    paint(&image);
    ng_result r = ng_image_make_mips(&image); // rough surfaces reflect them
    if (r == NG_OK && !ng_array_reserve(&l->added, l->added.count + 1))
        r = ng_out_of_memory(l->path);
    if (r != NG_OK) {
        ng_image_finish(&image);
        return r;
    }
    NG_TRY(ng_assets_take_image(l->assets, "default sky", &image, out));
    ng_array_push(&l->added, *out);
    return NG_OK;
}

// Whether a light of the standard's kinds gives any light: files keep some at a strength of 0.
static bool shines(const struct gltf_loader *l, ng_entity e)
{
    const struct ng_light_point *point = ng_world_get(l->world, e, NG_LIGHT_POINT);
    const struct ng_light_spot *spot = ng_world_get(l->world, e, NG_LIGHT_SPOT);
    const struct ng_light_directional *sun = ng_world_get(l->world, e, NG_LIGHT_DIRECTIONAL);
    const float *color = point ? point->color : spot ? spot->color : sun ? sun->color : NULL;
    float strength = point ? point->intensity : spot ? spot->intensity : sun ? sun->irradiance : 0;
    return color && strength > 0 && (color[0] > 0 || color[1] > 0 || color[2] > 0);
}

// Lights of our own kinds may be dark because their author wants that.
static bool has_light(const struct gltf_loader *l)
{
    bool shining = l->out.light_count && !l->out.foreign;
    for (uint32_t i = 0; !shining && l->out.light_count && i < l->order_count; i++)
        shining = shines(l, l->nodes[l->order[i]]);
    return shining;
}

ng_result ng_gltf_sky(struct gltf_loader *l)
{
    struct ng_light_environment sky;
    if (!l->limits.default_light || has_light(l))
        return NG_OK;
    memcpy(&sky, ng_light_environment_component.defaults, sizeof sky);
    NG_TRY(make_map(l, &sky.map));
    NG_TRY(ng_gltf_entity(l, l->out.root, "default sky", "sky", 0, &l->out.sky));
    NG_TRY(ng_gltf_add(l, l->out.sky, "default sky", NG_TRANSFORM, ng_transform_component.defaults));
    NG_TRY(ng_gltf_add(l, l->out.sky, "default sky", NG_LIGHT_ENVIRONMENT, &sky));
    l->out.light_count++;
    return NG_OK;
}

void ng_gltf_say_made(const struct gltf_loader *l)
{
    bool dark = l->out.light_count > l->out.emitter_count + 1;
    if (!l->out.primitive_count)
        ng_log_info("%s: has no mesh in its scene; only the background is seen", l->path);
    else if (!ng_entity_is_null(l->out.sky))
        ng_log_info("%s: has no light%s%s; a default sky lights it%s", l->path, dark ? " that shines" : "",
                    l->out.emitter_count ? " but what glows" : "", l->out.emitter_count ? ", too" : "");
}
