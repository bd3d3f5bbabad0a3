// How a scene is opened: what is made where its file says nothing. Options of every command that shows,
// measures or samples scenes, so that what one of them does with a file the others do, too.
#ifndef LIGHTFORMER_OPENING_H
#define LIGHTFORMER_OPENING_H

#include "options.h"

#include "render/extract.h"

struct ng_stage_params;

// How its file is read: of every command that opens one. A member `loading`, or one of `opening`.
struct loading {
    bool strict;
    double memory_limit; // MiB; 0: the default
};

#define CLI_STRICT(type_, member_)                                                                           \
    {                                                                                                        \
        .name = "--strict", .kind = CLI_FLAG, .offset = offsetof(type_, member_.strict),                     \
        .doc = "a fault in the scene's file refuses it, instead of costing the part that has it"             \
    }
#define CLI_MEMORY_LIMIT(type_, member_)                                                                     \
    {                                                                                                        \
        .name = "--memory-limit", .kind = CLI_REAL, .offset = offsetof(type_, member_.memory_limit),         \
        .value = "MIB", .min = 1, .max = 1e9,                                                                \
        .doc = "what a scene may take when it is loaded; half of what is available if not given"             \
    }
#define CLI_LOADING(type_, member_) CLI_STRICT(type_, member_), CLI_MEMORY_LIMIT(type_, member_)

// A member `opening` of the command's struct.
struct opening {
    struct loading loading;
    bool no_default_light;
    uint32_t emissive_lights; // index into opening_emitters
    const char *clip, *exposure;
    double stops;
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
#define CLI_STOPS(type_)                                                                                     \
    {                                                                                                        \
        .name = "--stops", .kind = CLI_REAL, .flags = CLI_PICTURE, .offset = offsetof(type_, opening.stops), \
        .value = "N", .min = -16, .max = 16, .doc = "brighter by so many stops than --exposure says"         \
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
// All of them, and their names, for lists of what excludes them.
#define OPENING_NAMES                                                                                        \
    "--clip", "--exposure", "--stops", "--no-default-light", "--emissive-lights", "--strict", "--memory-limit"
#define CLI_OPENING(type_)                                                                                   \
    CLI_CLIP(type_), CLI_EXPOSURE(type_), CLI_STOPS(type_), CLI_NO_DEFAULT_LIGHT(type_),                     \
        CLI_EMISSIVE_LIGHTS(type_), CLI_LOADING(type_, opening.loading)

// False, reported, if a value is none.
bool opening_check(const struct opening *opening, const char *command);
// As a stage takes it.
struct ng_exposure opening_exposure(const struct opening *opening);
// Bytes; 0: the default.
uint64_t loading_memory(const struct loading *loading);
void loading_apply(const struct loading *loading, struct ng_stage_params *params);
void opening_apply(const struct opening *opening, struct ng_stage_params *params);
// What pictures follow from besides the file: `hash`, changed by what is not left at its default. The
// exposure is no part of it.
uint64_t opening_hash(const struct opening *opening, uint64_t hash);

#endif
