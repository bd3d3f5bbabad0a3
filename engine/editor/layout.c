#include "editor/layout.h"

#include <math.h>
#include <stdbool.h>

#define MARGIN  8.0f   // around all of them
#define GAP     6.0f   // between two
#define FOOT    44.0f  // for captions below
#define SHARE   0.6f   // of the window's width, which panels may cover
#define LEAST   160.0f // of it in any case, pixels
#define SLENDER 120.0f // no column is narrower for want of room

// Heights of one column, which together fit: small panels get what they want, the others share the rest.
static void share_height(struct ng_panel *panels, uint32_t count, float height)
{
    float left = height - GAP * (float)(count - 1);
    uint32_t open = count;
    for (uint32_t i = 0; i < count; i++)
        panels[i].size[1] = -1;
    for (bool settled = false; !settled;) {
        float part = fmaxf(left, 0) / (float)(open ? open : 1);
        settled = true;
        for (uint32_t i = 0; i < count; i++) {
            if (panels[i].size[1] >= 0 || panels[i].wanted[1] > part)
                continue;
            panels[i].size[1] = panels[i].wanted[1];
            left -= panels[i].wanted[1];
            open--;
            settled = false;
        }
    }
    for (uint32_t i = 0; i < count; i++)
        if (panels[i].size[1] < 0)
            panels[i].size[1] = fmaxf(left, 0) / (float)open;
}

// Panels from the first one on that fit below each other.
static uint32_t fill_column(const struct ng_panel *panels, uint32_t count, float height)
{
    uint32_t n = 1;
    float used = panels[0].wanted[1];
    while (n < count && used + GAP + panels[n].wanted[1] <= height)
        used += GAP + panels[n++].wanted[1];
    return n;
}

void ng_layout_panels(float width, float height, struct ng_panel *panels, uint32_t count)
{
    float right = MARGIN + fminf(fmaxf(SHARE * width, LEAST), fmaxf(width - 2 * MARGIN, 0));
    float tall = fmaxf(height - 2 * MARGIN - FOOT, 0), x = MARGIN;
    for (uint32_t i = 0; i < count;) {
        uint32_t n = fill_column(panels + i, count - i, tall);
        float widest = 0;
        for (uint32_t k = i; k < i + n; k++)
            widest = fmaxf(widest, panels[k].wanted[0]);
        if (x + widest + GAP + SLENDER > right) { // no other column beside it
            n = count - i;
            for (uint32_t k = i; k < count; k++)
                widest = fmaxf(widest, panels[k].wanted[0]);
        }
        share_height(panels + i, n, tall);
        float y = MARGIN;
        for (uint32_t k = i; k < i + n; k++) {
            panels[k].at[0] = x;
            panels[k].at[1] = y;
            panels[k].size[0] = fminf(panels[k].wanted[0], fmaxf(right - x, 0));
            y += panels[k].size[1] + GAP;
        }
        x += widest + GAP;
        i += n;
    }
}
