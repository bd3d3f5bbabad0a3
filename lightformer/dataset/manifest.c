// Settings and shards are words and numbers; a manifest is small enough to be rewritten after every shard.
#include "lightformer/dataset/manifest.h"

#include "base/file.h"
#include "base/log.h"
#include "lightformer/tensors/json_reader.h"
#include "lightformer/tensors/text.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MANIFEST_LIMIT ((uint64_t)64 << 20) // bytes

bool lf_shard_path(const char *directory, const struct lf_shard *shard, char *out, size_t size)
{
    int n = snprintf(out, size, "%s/shard-%010" PRIu64 "-%010" PRIu64 ".safetensors", directory,
                     shard->first_seed, shard->first_seed + shard->samples - 1);
    return n > 0 && (size_t)n < size;
}

const char *lf_shard_of_name(const char *name, struct lf_shard *out)
{
    char path[64];
    uint64_t last;
    // Digits are few enough not to overflow; whether they are as we write them, the comparison says.
    if (sscanf(name, "shard-%10" SCNu64 "-%10" SCNu64, &out->first_seed, &last) != 2 ||
        last < out->first_seed || last - out->first_seed >= UINT32_MAX)
        return NULL;
    out->samples = (uint32_t)(last - out->first_seed + 1);
    out->hash = 0;
    if (!lf_shard_path("", out, path, sizeof path))
        return NULL;
    size_t length = strlen(ng_path_name(path));
    return strncmp(name, ng_path_name(path), length) == 0 ? name + length : NULL;
}

static bool manifest_path(const char *directory, char *out, size_t size)
{
    int n = snprintf(out, size, "%s/manifest.json", directory);
    return n > 0 && (size_t)n < size;
}

const struct lf_setting *lf_settings_difference(const struct lf_settings *a, const struct lf_settings *b)
{
    for (int i = 0; i < LF_SETTING_COUNT; i++)
        if (strcmp(a->items[i].key, b->items[i].key) != 0 ||
            strcmp(a->items[i].value, b->items[i].value) != 0)
            return &a->items[i];
    return NULL;
}

void lf_manifest_finish(struct lf_manifest *manifest)
{
    ng_array_finish(&manifest->shards);
    *manifest = (struct lf_manifest){0};
}

static bool overlap(const struct lf_shard *a, const struct lf_shard *b)
{
    return a->first_seed < b->first_seed + b->samples && b->first_seed < a->first_seed + a->samples;
}

const struct lf_shard *lf_manifest_find(const struct lf_manifest *m, const struct lf_shard *shard)
{
    for (size_t i = 0; i < m->shards.count; i++)
        if (m->shards.items[i].first_seed == shard->first_seed &&
            m->shards.items[i].samples == shard->samples)
            return &m->shards.items[i];
    return NULL;
}

ng_result lf_manifest_put(struct lf_manifest *m, const struct lf_shard *shard)
{
    size_t kept = 0, at = 0;
    if (!ng_array_reserve(&m->shards, m->shards.count + 1))
        return ng_out_of_memory("the manifest of a data set");
    for (size_t i = 0; i < m->shards.count; i++)
        if (!overlap(&m->shards.items[i], shard))
            m->shards.items[kept++] = m->shards.items[i];
    while (at < kept && m->shards.items[at].first_seed < shard->first_seed)
        at++;
    memmove(m->shards.items + at + 1, m->shards.items + at, (kept - at) * sizeof *shard);
    m->shards.items[at] = *shard;
    m->shards.count = kept + 1;
    return NG_OK;
}

// ---- the file --------------------------------------------------------------------------------------------

static bool read_settings(struct lf_json *j, struct lf_settings *out)
{
    int count = 0;
    lf_json_open(j, '{');
    while (lf_json_more(j, '}')) {
        if (count == LF_SETTING_COUNT)
            return false;
        struct lf_setting *note = &out->items[count++];
        if (!lf_json_key(j, note->key, sizeof note->key) ||
            !lf_json_string(j, note->value, sizeof note->value))
            return false;
    }
    return !j->failed && count == LF_SETTING_COUNT;
}

static bool read_hash(struct lf_json *j, uint64_t *out)
{
    char digits[17], *end;
    if (!lf_json_string(j, digits, sizeof digits))
        return false;
    *out = strtoull(digits, &end, 16);
    return end == digits + 16;
}

static bool read_shard(struct lf_json *j, struct lf_shard *out)
{
    uint64_t samples = 0;
    *out = (struct lf_shard){0};
    lf_json_open(j, '{');
    while (lf_json_more(j, '}')) {
        char key[16];
        if (!lf_json_key(j, key, sizeof key))
            return false;
        if (!(strcmp(key, "first_seed") == 0 ? lf_json_number(j, &out->first_seed)
              : strcmp(key, "samples") == 0  ? lf_json_number(j, &samples)
              : strcmp(key, "hash") == 0     ? read_hash(j, &out->hash)
                                             : lf_json_skip(j)))
            return false;
    }
    out->samples = (uint32_t)samples;
    return !j->failed && samples > 0 && samples <= UINT32_MAX;
}

static bool read_shards(struct lf_json *j, struct lf_manifest *out)
{
    lf_json_open(j, '[');
    while (lf_json_more(j, ']')) {
        struct lf_shard shard;
        if (!read_shard(j, &shard))
            return false;
        if (out->shards.count) {
            const struct lf_shard *last = &out->shards.items[out->shards.count - 1];
            if (shard.first_seed < last->first_seed + last->samples)
                return false;
        }
        if (!ng_array_push(&out->shards, shard))
            return false;
    }
    return !j->failed;
}

static bool parse(struct lf_json *j, struct lf_manifest *out)
{
    bool settings = false, shards = false;
    lf_json_open(j, '{');
    while (lf_json_more(j, '}')) {
        char key[16];
        if (!lf_json_key(j, key, sizeof key))
            return false;
        if (strcmp(key, "settings") == 0 && !settings)
            settings = read_settings(j, &out->settings);
        else if (strcmp(key, "shards") == 0 && !shards)
            shards = read_shards(j, out);
        else
            return false;
    }
    return lf_json_end(j) && settings && shards;
}

ng_result lf_manifest_read(const char *directory, struct lf_manifest *out)
{
    char path[4096];
    void *text;
    size_t size;
    *out = (struct lf_manifest){0};
    if (!manifest_path(directory, path, sizeof path) || !ng_file_exists(path))
        return NG_ERROR_NOT_FOUND;
    NG_TRY(ng_file_read(path, MANIFEST_LIMIT, &text, &size));
    struct lf_json j = lf_json_begin(text, size);
    bool good = parse(&j, out);
    free(text);
    if (good)
        return NG_OK;
    ng_log_error("%s: is not the manifest of a data set; delete it, and its shards are found again", path);
    lf_manifest_finish(out);
    return NG_ERROR_FORMAT;
}

static void put_shard(struct lf_text *t, const struct lf_shard *s)
{
    char path[64], numbers[128];
    t->failed |= !lf_shard_path("", s, path, sizeof path);
    snprintf(numbers, sizeof numbers,
             ", \"first_seed\": %" PRIu64 ", \"samples\": %u, \"hash\": \"%016" PRIx64 "\"}", s->first_seed,
             s->samples, s->hash);
    lf_text_put(t, "\n    {\"file\": ");
    lf_text_quote(t, ng_path_name(path));
    lf_text_put(t, numbers);
}

static void put_manifest(struct lf_text *t, const struct lf_manifest *m)
{
    lf_text_put(t, "{\n  \"settings\": {");
    for (int i = 0; i < LF_SETTING_COUNT; i++) {
        lf_text_put(t, i ? ",\n    " : "\n    ");
        lf_text_quote(t, m->settings.items[i].key);
        lf_text_put(t, ": ");
        lf_text_quote(t, m->settings.items[i].value);
    }
    lf_text_put(t, "\n  },\n  \"shards\": [");
    for (size_t i = 0; i < m->shards.count; i++) {
        lf_text_put(t, i ? "," : "");
        put_shard(t, &m->shards.items[i]);
    }
    lf_text_put(t, "\n  ]\n}\n");
}

ng_result lf_manifest_write(const char *directory, const struct lf_manifest *m)
{
    char path[4096];
    struct lf_text t = {0};
    ng_result result;
    put_manifest(&t, m);
    if (t.failed || !manifest_path(directory, path, sizeof path))
        result = ng_out_of_memory("the manifest of a data set");
    else
        result = ng_file_write(path, t.bytes.items, t.bytes.count);
    ng_array_finish(&t.bytes);
    return result;
}

// ---- shards ----------------------------------------------------------------------------------------------

static bool has_settings(const struct lf_tensors *t, const struct lf_settings *settings)
{
    for (int i = 0; i < LF_SETTING_COUNT; i++) {
        const char *noted = lf_tensors_noted(t, settings->items[i].key);
        if (!noted || strcmp(noted, settings->items[i].value) != 0)
            return false;
    }
    return true;
}

// Null, or what is wrong.
static const char *mismatch(const struct lf_shard *shard, const struct lf_tensors *t)
{
    char number[32];
    const char *first = lf_tensors_noted(t, "first_seed"), *samples = lf_tensors_noted(t, "samples");
    snprintf(number, sizeof number, "%" PRIu64, shard->first_seed);
    if (!first || strcmp(first, number) != 0)
        return "holds other seeds than its name says";
    snprintf(number, sizeof number, "%u", shard->samples);
    if (!samples || strcmp(samples, number) != 0)
        return "holds other seeds than its name says";
    return shard->hash && shard->hash != t->hash ? "is not the one that the manifest lists" : NULL;
}

ng_result lf_shard_try(const char *path, const struct lf_settings *settings, const struct lf_shard *shard,
                       struct lf_tensors *out, const char **wrong)
{
    NG_TRY(lf_tensors_try(path, out, wrong));
    bool same = has_settings(out, settings);
    *wrong = same ? mismatch(shard, out) : "was made with other settings";
    if (!*wrong)
        return NG_OK;
    lf_tensors_finish(out);
    return same ? NG_ERROR_FORMAT : NG_ERROR_UNSUPPORTED;
}

ng_result lf_shard_read(const char *directory, const struct lf_settings *settings,
                        const struct lf_shard *shard, struct lf_tensors *out)
{
    char path[4096];
    const char *wrong;
    *out = (struct lf_tensors){0};
    if (!lf_shard_path(directory, shard, path, sizeof path)) {
        ng_log_error("%s: the path is too long", directory);
        return NG_ERROR_IO;
    }
    ng_result result = lf_shard_try(path, settings, shard, out, &wrong);
    if (wrong)
        ng_log_error("%s: %s", path, wrong);
    return result;
}
