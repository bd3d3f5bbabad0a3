// A checkpoint: a header, the sums as they are in memory, a hash over both. For the machine that wrote it.
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "lightformer/reference/reference_internal.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC 0x31504b4346434c00u // changes with struct lf_sums or the order of the random numbers

struct header {
    uint64_t magic;
    uint64_t picture; // hash of parameters and the caller's key
    uint64_t pixels;
    uint64_t samples;
};

// Everything that the sums follow from, number by number: padding has no value.
static uint64_t hash_picture(const struct lf_reference *r, uint64_t picture)
{
    const struct lf_reference_params *p = &r->params;
    const uint64_t values[] = {p->width,        p->height,        p->region.x, p->region.y,
                               p->region.width, p->region.height, p->depth,    (uint64_t)p->sampler,
                               p->seed,         p->antialias,     picture};
    return ng_hash_bytes(ng_hash_bytes(0, &p->clamp, sizeof p->clamp), values, sizeof values);
}

static size_t file_size(const struct lf_reference *r)
{
    return sizeof(struct header) + lf_pixel_count(r) * sizeof *r->sums + sizeof(uint64_t);
}

ng_result lf_checkpoint_write(const struct lf_reference *r, const char *path, uint64_t picture)
{
    size_t size = file_size(r), body = size - sizeof(uint64_t);
    unsigned char *data = malloc(size);
    if (!data)
        return ng_out_of_memory(path);
    struct header header = {MAGIC, hash_picture(r, picture), lf_pixel_count(r), r->samples};
    memcpy(data, &header, sizeof header);
    memcpy(data + sizeof header, r->sums, body - sizeof header);
    uint64_t hash = ng_hash_bytes(0, data, body);
    memcpy(data + body, &hash, sizeof hash);
    ng_result result = ng_file_write(path, data, size);
    free(data);
    return result;
}

static ng_result take(struct lf_reference *r, const char *path, uint64_t picture, const unsigned char *data,
                      size_t size)
{
    struct header header = {0};
    uint64_t hash = 0;
    size_t body = size < sizeof hash ? 0 : size - sizeof hash;
    if (body >= sizeof header) {
        memcpy(&header, data, sizeof header);
        memcpy(&hash, data + body, sizeof hash);
    }
    if (header.magic != MAGIC || ng_hash_bytes(0, data, body) != hash || header.samples > UINT32_MAX) {
        ng_log_error("%s: not a whole checkpoint of this program; remove it to start anew", path);
        return NG_ERROR_FORMAT;
    }
    if (header.picture != hash_picture(r, picture) || size != file_size(r)) {
        ng_log_error("%s: the checkpoint is of another picture; give another file, or the options it was "
                     "made with",
                     path);
        return NG_ERROR_FORMAT;
    }
    memcpy(r->sums, data + sizeof header, body - sizeof header);
    r->samples = (uint32_t)header.samples;
    return NG_OK;
}

ng_result lf_checkpoint_read(struct lf_reference *r, const char *path, uint64_t picture)
{
    void *data;
    size_t size;
    NG_TRY(ng_file_read(path, 0, &data, &size));
    ng_result result = take(r, path, picture, data, size);
    free(data);
    return result;
}
