#include "view_picture.h"

#include "lightformer/methods/methods.h"

#include <math.h>

#define DIVIDER_STEP 0.05f
#define REACH        8.0f // pixels on each side of the divider that take hold of it

static const char *const comparisons[] = {
    [NG_COMPARE_NOTHING] = "alone", [NG_COMPARE_SPLIT] = "split", [NG_COMPARE_DIFFERENCE] = "difference"};

const char *view_comparison_name(uint32_t comparison)
{
    return comparison < NG_COUNT(comparisons) ? comparisons[comparison] : NULL;
}

// Alone, the other side keeps the method that was shown before: the natural one to compare with.
static void choose_method(struct view_picture *p, uint32_t method)
{
    struct view_side *side = &p->sides[p->active];
    if (p->comparison == NG_COMPARE_NOTHING && method != side->method)
        p->sides[VIEW_RIGHT].method = side->method;
    side->method = method;
}

static void choose_by_key(struct view_picture *p, const struct ng_input *input)
{
    for (uint32_t i = 0; i < LF_METHODS; i++)
        if (input->pressed['1' + i])
            choose_method(p, i);
}

// Both sides go along while they show the same layer, so that methods stay compared like with like.
static void next_layer(struct view_picture *p, bool alone)
{
    struct view_side *active = &p->sides[p->active], *other = &p->sides[1 - p->active];
    bool along = !alone && other->layer == active->layer;
    active->layer = ng_display_layer(active->layer + 1) ? active->layer + 1 : 0;
    if (along)
        other->layer = active->layer;
}

static void swap_sides(struct view_picture *p)
{
    struct view_side left = p->sides[VIEW_LEFT];
    p->sides[VIEW_LEFT] = p->sides[VIEW_RIGHT];
    p->sides[VIEW_RIGHT] = left;
}

static void drag_divider(struct view_picture *p, const struct ng_input *input, float width)
{
    // Also if it is up again by now, so that no drag is lost between two slow frames.
    bool down = input->buttons[NG_BUTTON_LEFT] || input->drag[NG_BUTTON_LEFT][0] != 0;
    bool near = fabsf(input->grip[NG_BUTTON_LEFT][0] - p->divider * width) <= REACH;
    bool taken = p->dragging || (!p->held && near);
    p->dragging = down && width > 0 && p->comparison == NG_COMPARE_SPLIT && taken;
    p->held = down;
    if (p->dragging)
        p->divider = input->pointer[0] / width;
}

void view_picture_react(struct view_picture *p, const struct ng_input *input, uint32_t width)
{
    choose_by_key(p, input);
    for (int i = 0; i < input->pressed['L']; i++)
        next_layer(p, i < input->shifted['L']);
    for (int i = 0; i < input->pressed['C']; i++)
        p->comparison = view_comparison_name(p->comparison + 1) ? p->comparison + 1 : NG_COMPARE_NOTHING;
    if (p->comparison == NG_COMPARE_NOTHING)
        p->active = VIEW_LEFT;
    else if (input->pressed[NG_KEY_TAB] % 2)
        p->active = 1 - p->active;
    if (input->pressed['X'] % 2)
        swap_sides(p);
    p->divider += DIVIDER_STEP * (float)(input->pressed['.'] - input->pressed[',']);
    drag_divider(p, input, (float)width);
    p->divider = fminf(fmaxf(p->divider, 0), 1);
}

const char *view_picture_method(const struct view_picture *p)
{
    return lf_method_name(p->sides[VIEW_LEFT].method);
}

struct ng_shown view_picture_shown(const struct view_picture *p)
{
    return (struct ng_shown){.layer = ng_display_layer(p->sides[VIEW_LEFT].layer),
                             .comparison = p->comparison,
                             .other_layer = ng_display_layer(p->sides[VIEW_RIGHT].layer),
                             .other_method = lf_method_name(p->sides[VIEW_RIGHT].method),
                             .divider = p->divider};
}
