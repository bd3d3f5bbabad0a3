// How a scene is opened: what is made where its file says nothing. Options of every command that shows
// scenes.
#ifndef LIGHTFORMER_OPENING_H
#define LIGHTFORMER_OPENING_H

#include "options.h"

struct ng_stage_params;

// A member `opening` of the command's struct.
struct opening {
    bool no_default_light;
    uint32_t emissive_lights; // index into opening_emitters
    const char *clip, *exposure;
};

extern const char *const opening_emitters[];

#define CLI_CLIP(type_)                                                                                      \
    {                                                                                                        \
        .name = "--clip", .kind = CLI_TEXT, .flags = CLI_PICTURE, .offset = offsetof(type_, opening.clip),   \
        .value = "NAME|all|none",                                                                            \
        .doc = "which clip plays; if not given, the first of those that drive the same thing"                \
    }
#define CLI_EXPOSURE(type_)                                                                                  \
    {                                                                                                        \
        .name = "--exposure", .kind = CLI_TEXT, .flags = CLI_PICTURE,                                        \
        .offset = offsetof(type_, opening.exposure), .value = "EV|auto",                                     \
        .doc = "stops, 0: radiance as it is; if not given the camera's, or auto without NG_scene"            \
    }
#define CLI_NO_DEFAULT_LIGHT(type_)                                                                          \
    {                                                                                                        \
        .name = "--no-default-light", .kind = CLI_FLAG, .flags = CLI_PICTURE,                                \
        .offset = offsetof(type_, opening.no_default_light), .doc = "a scene without any light gets no sky"  \
    }
#define CLI_EMISSIVE_LIGHTS(type_)                                                                           \
    {                                                                                                        \
        .name = "--emissive-lights", .kind = CLI_CHOICE, .flags = CLI_PICTURE,                               \
        .offset = offsetof(type_, opening.emissive_lights), .value = "HOW", .choices = opening_emitters,     \
        .doc = "whether emissive meshes are lights; auto: without NG_scene"                                  \
    }
// All of them.
#define CLI_OPENING(type_)                                                                                   \
    CLI_CLIP(type_), CLI_EXPOSURE(type_), CLI_NO_DEFAULT_LIGHT(type_), CLI_EMISSIVE_LIGHTS(type_)

// False, reported, if a value is none.
bool opening_check(const struct opening *opening, const char *command);
void opening_apply(const struct opening *opening, struct ng_stage_params *params);

#endif
