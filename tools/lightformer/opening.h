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
    const char *clip;
};

extern const char *const opening_emitters[];

#define CLI_OPENING(type_)                                                                                   \
    {.name = "--clip",                                                                                       \
     .kind = CLI_TEXT,                                                                                       \
     .flags = CLI_PICTURE,                                                                                   \
     .offset = offsetof(type_, opening.clip),                                                                \
     .value = "NAME|all|none",                                                                               \
     .doc = "which clip plays; if not given, the first of those that drive the same thing"},                 \
        {.name = "--no-default-light",                                                                       \
         .kind = CLI_FLAG,                                                                                   \
         .flags = CLI_PICTURE,                                                                               \
         .offset = offsetof(type_, opening.no_default_light),                                                \
         .doc = "a scene without any light gets no sky"},                                                    \
    {                                                                                                        \
        .name = "--emissive-lights", .kind = CLI_CHOICE, .flags = CLI_PICTURE,                               \
        .offset = offsetof(type_, opening.emissive_lights), .value = "on|off", .choices = opening_emitters,  \
        .doc = "emissive meshes light the scene; auto: in files without NG_scene"                            \
    }

void opening_apply(const struct opening *opening, struct ng_stage_params *params);

#endif
