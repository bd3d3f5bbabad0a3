// The subcommands. Each is one file, command_NAME.c: a struct of values, a table of options and a function.
// To add one, copy command_info.c and add it to the list in main.c.
#ifndef LIGHTFORMER_COMMANDS_H
#define LIGHTFORMER_COMMANDS_H

#include "method_options.h"
#include "opening.h"
#include "options.h"

// Options that mean the same in several commands; the command's struct has a member of the option's name.
#define CLI_SCENE(type_)                                                                                     \
    CLI_ARGUMENT(type_, scene, "SCENE", "a glTF file (.glb or .gltf), an OBJ file, or FILE.sh3f#PIECE")
#define CLI_METHOD(type_, names_)                                                                            \
    {                                                                                                        \
        .name = "--method", .kind = CLI_CHOICE, .flags = CLI_PICTURE, .offset = offsetof(type_, method),     \
        .value = "NAME", .fallback = "auto", .choice = (names_),                                             \
        .doc = "how light is computed; auto: neural if there are weights, else raster"                       \
    }
#define CLI_WEIGHTS(type_)                                                                                   \
    {                                                                                                        \
        .name = "--weights", .kind = CLI_TEXT, .flags = CLI_PICTURE | CLI_PATH | CLI_READS,                  \
        .offset = offsetof(type_, weights), .value = "FILE",                                                 \
        .doc = "neural: the network; if not given SCENE.weights.safetensors beside the scene"                \
    }
#define CLI_GBUFFER(type_)                                                                                   \
    {                                                                                                        \
        .name = "--gbuffer", .kind = CLI_CHOICE, .offset = offsetof(type_, gbuffer), .value = "HOW",         \
        .fallback = "auto", .choices = method_gbuffers,                                                      \
        .doc = "neural: what finds the surface of each pixel; auto: rays if the device is a CPU"             \
    }
#define CLI_PIXELS(type_, default_)                                                                          \
    {                                                                                                        \
        .name = "--size", .kind = CLI_SIZE, .flags = CLI_PICTURE, .offset = offsetof(type_, size),           \
        .value = "WxH", .fallback = (default_), .min = 1, .max = 16384, .doc = "pixels"                      \
    }
#define CLI_THREADS(type_)                                                                                   \
    {                                                                                                        \
        .name = "--threads", .kind = CLI_COUNT, .offset = offsetof(type_, threads), .value = "N",            \
        .fallback = "0", .max = 256, .doc = "threads of the CPU; 0: one a processor"                         \
    }
#define CLI_DEVICE(type_)                                                                                    \
    {                                                                                                        \
        .name = "--device", .kind = CLI_TEXT, .offset = offsetof(type_, device), .value = "NAME",            \
        .doc = "a graphics device, by number or part of its name (lightformer info device)"                  \
    }
#define CLI_JSON(type_)                                                                                      \
    {                                                                                                        \
        .name = "--json", .kind = CLI_FLAG, .offset = offsetof(type_, json), .doc = "print JSON"             \
    }

#define CLI_FRAMES_A_SECOND 30.0

// A picture that others than `render` have made, by the options with which that makes the same.
struct render_picture {
    const char *scene, *weights, *pose, *method;
    struct cli_size size;
    double time;
    uint32_t samples; // of the method "reference", and of what is antialiased
    bool antialias;
    struct opening opening;
};
// The canonical command (options.h); false if it does not fit.
bool render_canonical(const struct render_picture *picture, char *out, size_t size);

extern const struct cli_command cli_render_command;
extern const struct cli_command cli_view_command;
extern const struct cli_command cli_info_command;
extern const struct cli_command cli_bench_command;
extern const struct cli_command cli_compare_command;
extern const struct cli_command cli_dataset_command;
extern const struct cli_command cli_net_command;
extern const struct cli_command cli_convert_command;

#endif
