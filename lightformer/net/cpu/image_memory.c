// Which images of the executor share memory: those of equal size, of any number of rows, of which one is read
// for the last time before the other is written. Of equal size, as then the columns of zeros at both sides
// coincide and nobody writes there; lines above and below are cleared before each use (executor.c).
#include "lightformer/net/cpu/plan_internal.h"

#include <stdlib.h>

// The first and the last segment that use an image; before any does, begin > end.
struct life {
    uint32_t begin, end;
};

// A nested segment runs with the one around it.
static uint32_t time_of(const struct lf_plan *plan, uint32_t segment)
{
    if (plan->segments.items[segment].nested)
        for (uint32_t i = segment + 1; i < plan->segments.count; i++)
            if (plan->segments.items[i].inner == segment)
                return i;
    return segment;
}

static void find_lives(const struct lf_plan *plan, struct life *lives)
{
    for (size_t i = 0; i < plan->images.count; i++)
        lives[i] = (struct life){.begin = UINT32_MAX};
    for (uint32_t i = 0; i < plan->segments.count; i++) {
        uint32_t time = time_of(plan, i);
        for (uint32_t c = plan->segments.items[i].code_begin; c < plan->segments.items[i].code_end; c++) {
            if (plan->codes.items[c].image == LF_NO_VALUE)
                continue;
            struct life *life = &lives[plan->codes.items[c].image];
            life->begin = time < life->begin ? time : life->begin;
            life->end = time > life->end ? time : life->end;
        }
    }
}

// Rows that only fill up a product's operand are never written. Their weights are zero, but what another
// image left there might not be finite.
static bool has_spare_rows(const struct lf_plan *plan, const struct lf_image_plan *image)
{
    uint32_t channels = plan->net->values.items[image->value].channels;
    return image->rows != (channels + plan->group - 1) / plan->group;
}

static bool may_share(const struct lf_plan *plan, const struct lf_image_plan *a,
                      const struct lf_image_plan *b)
{
    const struct lf_value *va = &plan->net->values.items[a->value], *vb = &plan->net->values.items[b->value];
    bool rows = lf_is_rows(va->domain) || lf_is_rows(vb->domain);
    bool equal = va->channels == vb->channels && a->rows == b->rows;
    return (rows ? va->domain == vb->domain : va->level == vb->level) &&
           (equal || (!rows && !has_spare_rows(plan, a) && !has_spare_rows(plan, b)));
}

// Whether the image may have the slot: nobody in it lives at the same time.
static bool is_free(const struct lf_plan *plan, const struct life *lives, size_t image, uint32_t slot)
{
    for (size_t i = 0; i < image; i++) {
        const struct lf_image_plan *other = &plan->images.items[i];
        if (other->owner != LF_IMAGE_SHARED || other->slot != slot)
            continue;
        if (!may_share(plan, &plan->images.items[image], other) ||
            (lives[i].begin <= lives[image].end && lives[image].begin <= lives[i].end))
            return false;
    }
    return true;
}

bool lf_plan_share_images(struct lf_plan *plan)
{
    struct life *lives = calloc(plan->images.count + 1, sizeof *lives);
    if (!lives)
        return false;
    find_lives(plan, lives);
    plan->image_counts[LF_IMAGE_SHARED] = 0;
    for (size_t i = 0; i < plan->images.count; i++) {
        struct lf_image_plan *image = &plan->images.items[i];
        if (image->owner != LF_IMAGE_SHARED)
            continue;
        image->first = lives[i].begin;
        image->slot = 0;
        while (!is_free(plan, lives, i, image->slot))
            image->slot++;
        if (image->slot == plan->image_counts[LF_IMAGE_SHARED])
            plan->image_counts[LF_IMAGE_SHARED]++;
    }
    free(lives);
    return true;
}
