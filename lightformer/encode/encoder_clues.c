// Clues, texels and embeddings by name, for people who want to see them.
#include "lightformer/encode/encoder_internal.h"

#include "base/log.h"
#include "base/printable.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EMBEDDING "embedding."

// A name in parts: the light, or "" for what belongs to the picture, and the rest.
struct clue_name {
    char light[NG_TEXT_SIZE + 32];
    const char *what;
    int input;      // enum lf_net_input; -1: an embedding
    uint32_t image; // of the embedding
};

static int find_input(const char *name)
{
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        if (strcmp(lf_net_inputs[i].name, name) == 0)
            return i;
    return -1;
}

static bool is_rows(enum lf_net_domain domain)
{
    return domain == LF_DOMAIN_VPL || domain == LF_DOMAIN_TEXEL;
}

static bool is_of_picture(enum lf_net_domain domain)
{
    return domain == LF_DOMAIN_PIXEL;
}

static bool is_shown(enum lf_net_domain domain)
{
    return domain == LF_DOMAIN_PIXEL || domain == LF_DOMAIN_VIEW || is_rows(domain);
}

// The name of a light may hold a '/'; that of a clue does not.
static bool parse(const char *clue, struct clue_name *out)
{
    const char *slash = strrchr(clue, '/');
    size_t length = slash ? (size_t)(slash - clue) : 0;
    *out = (struct clue_name){.what = slash ? slash + 1 : clue};
    if (length >= sizeof out->light || (slash && !length))
        return false;
    memcpy(out->light, clue, length);
    out->input = find_input(out->what);
    if (out->input >= 0) {
        enum lf_net_domain domain = lf_net_inputs[out->input].domain;
        return is_shown(domain) && is_of_picture(domain) == !slash;
    }
    char *end;
    if (!slash || strncmp(out->what, EMBEDDING, strlen(EMBEDDING)) != 0)
        return false;
    out->image = (uint32_t)strtoul(out->what + strlen(EMBEDDING), &end, 10);
    return end != out->what + strlen(EMBEDDING) && !*end;
}

bool lf_encoder_clue_buffer(const char *clue, char *out, size_t size)
{
    struct clue_name n;
    if (!parse(clue, &n))
        return false;
    int length;
    if (n.input >= 0 && (LF_ARRIVING_INPUTS >> n.input & 1))
        length = snprintf(out, size, "clues/arriving");
    else if (!n.light[0])
        length = snprintf(out, size, "clues/pixels");
    else {
        const char *part = n.input < 0                                       ? "embedding"
                           : lf_net_inputs[n.input].domain == LF_DOMAIN_VIEW ? "clues"
                                                                             : "rsm";
        length = snprintf(out, size, "encode:%s/%s", n.light, part);
    }
    return length > 0 && (size_t)length < size;
}

static const struct lf_active_light *find_light(const struct lf_encoder *self, const char *name)
{
    for (size_t i = 0; i < self->active.count; i++)
        if (strcmp(self->active.items[i].kept->name, name) == 0)
            return &self->active.items[i];
    return NULL;
}

static ng_result no_clue(const char *clue, const char *why)
{
    char shown[256];
    snprintf(shown, sizeof shown, "%s", clue);
    ng_make_printable(shown);
    ng_log_error("there is no clue \"%s\": %s", shown, why);
    return NG_ERROR_NOT_FOUND;
}

static ng_result show_embedding(const char *clue, const struct clue_name *n,
                                const struct lf_active_light *light, struct lf_clue *out)
{
    const struct lf_net_encoding *encoding = light->kept->encoding;
    if (!lf_net_encoding_image(encoding, n->image, &out->width, &out->height, &out->channels, NULL))
        return no_clue(clue, "the embedding has fewer images");
    out->own = malloc((size_t)out->width * out->height * out->channels * sizeof *out->own);
    if (!out->own)
        return ng_out_of_memory(clue);
    (void)lf_net_encoding_image(encoding, n->image, &out->width, &out->height, &out->channels, out->own);
    out->planes = out->own;
    return NG_OK;
}

ng_result lf_encoder_clue(const struct lf_encoder *self, const char *clue, struct lf_clue *out)
{
    struct clue_name n;
    *out = (struct lf_clue){0};
    if (!parse(clue, &n))
        return no_clue(clue, "clues are pixel.NAME, LIGHT/view.NAME, LIGHT/vpl.NAME, LIGHT/texel.NAME and "
                             "LIGHT/embedding.N; lightformer/net/inputs.inc lists them");
    const struct lf_active_light *light = n.light[0] ? find_light(self, n.light) : NULL;
    if (!light && (n.input < 0 || !is_of_picture(lf_net_inputs[n.input].domain)))
        return no_clue(
            clue, "no light of that name shines in the frame; `lightformer info SCENE` lists the lights");
    if (n.input < 0)
        return show_embedding(clue, &n, light, out);
    const struct lf_net_input_info *info = &lf_net_inputs[n.input];
    const struct lf_net_values *values =
        light ? lf_light_clues_values(light->kept->clues) : lf_pixel_clues_values(self->pixels);
    out->width = self->width;
    out->height = self->height;
    out->channels = info->channels;
    out->planes = values->of[n.input];
    if (light && is_rows(info->domain)) {
        out->width = info->domain == LF_DOMAIN_VPL ? lf_light_clues_vpls(light->kept->clues)
                                                   : lf_light_clues_texels(light->kept->clues);
        out->height = 1;
    }
    if (!out->planes || !out->width)
        return no_clue(clue, "the network does not read it, or nothing in the scene needs it");
    return NG_OK;
}

void lf_clue_finish(struct lf_clue *clue)
{
    free(clue->own);
    *clue = (struct lf_clue){0};
}
