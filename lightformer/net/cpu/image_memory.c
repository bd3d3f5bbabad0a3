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
    if (image->compact)
        return false;
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

// Rows of the largest image that has the slot so far.
static uint32_t rows_of_slot(const struct lf_plan *plan, size_t images, uint32_t slot)
{
    uint32_t rows = 0;
    for (size_t i = 0; i < images; i++) {
        const struct lf_image_plan *p = &plan->images.items[i];
        if (p->owner == LF_IMAGE_SHARED && p->slot == slot && p->rows > rows)
            rows = p->rows;
    }
    return rows;
}

// The free slot that has to grow least, of those the smallest; or a new one, if that takes less.
static uint32_t find_slot(const struct lf_plan *plan, const struct life *lives, size_t image)
{
    uint32_t rows = plan->images.items[image].rows, count = plan->image_counts[LF_IMAGE_SHARED], best = count,
             least_growth = rows, least_waste = 0;
    for (uint32_t slot = 0; slot < count; slot++) {
        uint32_t there = rows_of_slot(plan, image, slot), growth = rows > there ? rows - there : 0,
                 waste = there > rows ? there - rows : 0;
        bool better = growth < least_growth || (growth == least_growth && waste < least_waste);
        if (!better || !is_free(plan, lives, image, slot))
            continue;
        best = slot;
        least_growth = growth;
        least_waste = waste;
    }
    return best;
}

// Products and resampling look into an image at words that have a channel each.
static bool is_of_whole_rows(const struct lf_plan *plan, size_t image)
{
    for (size_t c = 0; c < plan->codes.count; c++) {
        const struct lf_code *code = &plan->codes.items[c];
        bool whole = code->kind == LF_CODE_LOAD_IMAGE || code->kind == LF_CODE_STORE_IMAGE ||
                     code->kind == LF_CODE_STORE_PACKED;
        if (code->image == image && !whole)
            return false;
    }
    return true;
}

void lf_plan_compact_images(struct lf_plan *plan)
{
    for (size_t i = 0; i < plan->images.count; i++) {
        struct lf_image_plan *image = &plan->images.items[i];
        const struct lf_value *value = &plan->net->values.items[image->value];
        if (image->owner == LF_IMAGE_LOCAL || plan->group > 1 || lf_is_rows(value->domain) ||
            !is_of_whole_rows(plan, i))
            continue;
        image->compact = true;
        image->rows = (value->channels + 1) / 2;
    }
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
        image->slot = find_slot(plan, lives, i);
        if (image->slot == plan->image_counts[LF_IMAGE_SHARED])
            plan->image_counts[LF_IMAGE_SHARED]++;
    }
    free(lives);
    return true;
}
