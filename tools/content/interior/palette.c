#include "palette.h"

const struct palette_entry palette[PALETTE_COUNT] = {
#define X(name, where, what) {#name, what, PALETTE_##where, palette_##name},
    PALETTE(X)
#undef X
};

void palette_place(struct glb *g, struct looks *looks, enum palette_piece piece, int node)
{
    struct furniture p;
    furniture_begin(&p, g, looks, palette[piece].name, node);
    palette[piece].build(&p);
    furniture_end(&p);
}

ng_result palette_file(enum palette_piece piece, struct bytes *out)
{
    struct glb g;
    struct looks looks = {0};
    glb_init(&g);
    int node = glb_add_node(&g, &(struct glb_node){.name = palette[piece].name});
    palette_place(&g, &looks, piece, node);
    return glb_finish(&g, out);
}
