#include "render_clues.h"

#include "asset/exr.h"
#include "base/log.h"
#include "base/printable.h"
#include "graph/graph.h"
#include "lightformer/neural/neural.h"

#include <stdio.h>
#include <string.h>

#define MOST_CHANNELS 256

const char *render_clue_file(const char *clue)
{
    const char *equals = strrchr(clue, '=');
    return equals ? equals + 1 : NULL;
}

// The part before the '='.
static bool clue_name(const char *clue, char *out, size_t size)
{
    const char *file = render_clue_file(clue);
    int length = file ? snprintf(out, size, "%.*s", (int)(file - 1 - clue), clue) : 0;
    return length > 0 && (size_t)length < size;
}

static bool is_exr(const char *path)
{
    size_t length = strlen(path);
    return length > 4 && strcmp(path + length - 4, ".exr") == 0;
}

bool render_clues_check(const struct cli_texts *clues)
{
    char name[256], buffer[256];
    for (uint32_t i = 0; i < clues->count; i++)
        if (!clue_name(clues->items[i], name, sizeof name) || !is_exr(render_clue_file(clues->items[i])) ||
            !lf_encoder_clue_buffer(name, buffer, sizeof buffer)) {
            ng_print_line(
                stderr,
                "lightformer render: --clue: \"%s\" is not NAME=FILE.exr, where NAME is pixel.INPUT, "
                "LIGHT/view.INPUT, LIGHT/vpl.INPUT, LIGHT/texel.INPUT (lightformer/net/inputs.inc) or "
                "LIGHT/embedding.NUMBER",
                clues->items[i]);
            return false;
        }
    return true;
}

void render_clues_name(const struct cli_texts *clues, struct render_clues *out)
{
    for (uint32_t i = 0; i < clues->count; i++) {
        char name[256];
        (void)clue_name(clues->items[i], name, sizeof name); // was checked
        (void)lf_encoder_clue_buffer(name, out->names[i], sizeof out->names[i]);
        out->resources[i] = out->names[i];
    }
}

// Channels by their number, or as colours where there are three.
static ng_result write_planes(const char *path, const struct lf_clue *clue)
{
    static const char *const colours[] = {"R", "G", "B"};
    struct ng_exr_channel channels[MOST_CHANNELS];
    char names[MOST_CHANNELS][16];
    NG_REQUIRE(clue->channels <= MOST_CHANNELS, "%s: a file holds at most %d channels", path, MOST_CHANNELS);
    for (uint32_t c = 0; c < clue->channels; c++) {
        snprintf(names[c], sizeof names[c], "%03u", c);
        const char *name = clue->channels == 1 ? "Y" : clue->channels == 3 ? colours[c] : names[c];
        channels[c] =
            (struct ng_exr_channel){.name = name,
                                    .type = NG_EXR_FLOAT,
                                    .pixels = clue->planes + (size_t)c * clue->width * clue->height};
    }
    return ng_exr_write(path, &(struct ng_exr_params){.width = clue->width,
                                                      .height = clue->height,
                                                      .channels = channels,
                                                      .channel_count = clue->channels});
}

static ng_result write_clue(const char *text, const char *resource, struct ng_graph *graph,
                            const struct lf_neural *neural)
{
    struct ng_graph_memory memory; // waits for the frame; what the clue is of it, the encoder knows
    struct lf_clue clue = {0};
    char name[256];
    (void)clue_name(text, name, sizeof name);
    ng_result result = lf_neural_clue(neural, name, &clue);
    if (result == NG_OK)
        result = ng_graph_readback_get(graph, resource, &memory);
    if (result == NG_OK)
        result = write_planes(render_clue_file(text), &clue);
    if (result == NG_OK)
        puts(render_clue_file(text));
    lf_clue_finish(&clue);
    return result;
}

ng_result render_clues_write(const struct cli_texts *clues, const struct render_clues *named,
                             struct ng_graph *graph, const struct lf_neural *neural)
{
    ng_result result = NG_OK;
    for (uint32_t i = 0; i < clues->count; i++) {
        ng_result r = write_clue(clues->items[i], named->resources[i], graph, neural);
        result = result == NG_OK ? r : result;
    }
    return result;
}
