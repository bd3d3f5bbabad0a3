// A picture of a test's scene and everything that is encoded of it, without a graphics device: the G-buffer
// is that of camera rays.
#ifndef NG_TESTS_ENCODE_PICTURE_H
#define NG_TESTS_ENCODE_PICTURE_H

#include "../reference/scene.h"

#include "lightformer/clues/clues.h"

struct picture {
    uint32_t width, height, lights;
    float *position;
    uint16_t *normal, *diffuse, *specular;
    float *emission;
    struct lf_pixel_clues *pixels;
    struct lf_light_clues *light[8];
};

// Encodes all lights of the scene's last frame. Call it again for another frame; the memory is reused.
void picture_encode(struct picture *p, const struct scene *s, uint32_t width, uint32_t height);
// The same with inputs as `reads` says, and parameters of lights.
void picture_encode_with(struct picture *p, const struct scene *s, uint32_t width, uint32_t height,
                         uint64_t reads, const struct lf_clues_light_params *params);
void picture_close(struct picture *p);

// Plane `channel` of an input.
const float *picture_pixels(const struct picture *p, enum lf_net_input input, uint32_t channel);
const float *picture_view(const struct picture *p, uint32_t light, enum lf_net_input input, uint32_t channel);
// What a light's radiance at unit power is multiplied by, W/(sr m2).
float picture_unit(const struct picture *p, uint32_t light);

// A hash of every input of the frame, or of those that do not hang on powers (`apart_from_power`). Fails
// where a number is not finite.
uint64_t picture_hash(const struct picture *p, bool apart_from_power);

// ---- scenes ----------------------------------------------------------------------------------------------

// A lamp of a colour, and a panel of 0.6 x 0.4 that shines down.
ng_entity picture_point(struct scene *s, float intensity, const float position[3]);
ng_entity picture_panel(struct scene *s, float radiance, const float position[3]);
// A smooth floor, a ball, a wall behind; with one of each, or dark.
void picture_room(struct scene *s, uint32_t threads);
void picture_dark_room(struct scene *s, uint32_t threads);

#endif
