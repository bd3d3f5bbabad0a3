// Where the buffers of a segment lie in the memory of a tile: each in the first gap among those that live at
// the same time.
#include "lightformer/net/cpu/segment_internal.h"

static void touch(struct lf_planner *p, struct lf_place place, uint32_t code)
{
    if (!lf_is_here(place))
        return;
    struct lf_buffer *b = &p->buffers.items[place.buffer];
    b->first = b->first < code ? b->first : code;
    b->last = b->last > code ? b->last : code;
}

// What is made before a loop over lights and read in it must last through all lights.
static void find_lives(struct lf_planner *p)
{
    const struct lf_plan *plan = p->plan;
    for (uint32_t i = p->segment->code_begin; i < plan->codes.count; i++) {
        const struct lf_code *c = &plan->codes.items[i];
        const struct lf_place places[] = {c->a, c->b, c->c, c->out, c->packed};
        for (size_t k = 0; k < NG_COUNT(places); k++)
            touch(p, places[k], i);
        for (uint32_t k = 0; c->kind == LF_CODE_PACK && k < c->list_count; k++)
            touch(p, plan->lists.items[c->list + k], i);
    }
    for (uint32_t i = p->segment->phase_begin; i < plan->phases.count; i++) {
        const struct lf_phase *phase = &plan->phases.items[i];
        for (size_t k = 0; k < p->buffers.count; k++) {
            struct lf_buffer *b = &p->buffers.items[k];
            if (b->first < phase->lights && b->last >= phase->lights && b->last < phase->end)
                b->last = phase->end - 1;
        }
    }
}

static void place_buffer(struct lf_planner *p, size_t index)
{
    struct lf_buffer *b = &p->buffers.items[index];
    bool moved = true;
    b->offset = 0;
    while (moved) {
        moved = false;
        for (size_t i = 0; i < index; i++) {
            const struct lf_buffer *o = &p->buffers.items[i];
            if (o->first <= b->last && b->first <= o->last && o->offset < b->offset + b->rows &&
                b->offset < o->offset + o->rows) {
                b->offset = o->offset + o->rows;
                moved = true;
            }
        }
    }
    if (b->offset + b->rows > p->segment->rows)
        p->segment->rows = b->offset + b->rows;
}

static void resolve(const struct lf_planner *p, struct lf_place *place)
{
    if (!lf_is_here(*place))
        return;
    place->row += p->buffers.items[place->buffer].offset;
    place->buffer = 0;
}

void lf_place_buffers(struct lf_planner *p, uint32_t list_begin)
{
    struct lf_plan *plan = p->plan;
    find_lives(p);
    for (size_t i = 0; i < p->buffers.count; i++)
        if (p->buffers.items[i].first != UINT32_MAX)
            place_buffer(p, i);
        else
            p->buffers.items[i].last = 0;
    for (uint32_t i = p->segment->code_begin; i < plan->codes.count; i++) {
        struct lf_code *c = &plan->codes.items[i];
        struct lf_place *places[] = {&c->a, &c->b, &c->c, &c->out, &c->packed};
        for (size_t k = 0; k < NG_COUNT(places); k++)
            resolve(p, places[k]);
    }
    for (size_t i = list_begin; i < plan->lists.count; i++)
        resolve(p, &plan->lists.items[i]);
}
