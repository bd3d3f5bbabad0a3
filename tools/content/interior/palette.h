// The palette of Interior Design: pieces of furniture and lamps, each a file of its own below
// content/interior_design, and any of them inside of another scene.
//
// Lengths are in metres. A piece faces +Z. Its origin is where it touches what holds it: the floor, a table
// top, the wall behind it, the ceiling above it.
#ifndef CONTENT_PALETTE_H
#define CONTENT_PALETTE_H

#include "furniture.h"

// Name, where it belongs (FLOOR, TOP of something, WALL, CEILING), what it is.
#define PALETTE(X)                                                                                           \
    X(sofa, FLOOR, "sofa for three")                                                                         \
    X(leather_sofa, FLOOR, "sofa for two, leather in a frame of steel tube")                                 \
    X(armchair, FLOOR, "armchair of oak with loose cushions")                                                \
    X(tub_chair, FLOOR, "round armchair")                                                                    \
    X(pouf, FLOOR, "pouf")                                                                                   \
    X(dining_chair, FLOOR, "chair")                                                                          \
    X(bar_stool, FLOOR, "bar stool")                                                                         \
    X(office_chair, FLOOR, "office chair")                                                                   \
    X(bench, FLOOR, "bench with a pad")                                                                      \
    X(coffee_table, FLOOR, "coffee table")                                                                   \
    X(side_table, FLOOR, "side table, marble")                                                               \
    X(dining_table, FLOOR, "dining table for six")                                                           \
    X(desk, FLOOR, "desk with drawers")                                                                      \
    X(bedside_table, FLOOR, "bedside table")                                                                 \
    X(bed, FLOOR, "double bed, made")                                                                        \
    X(wardrobe, FLOOR, "wardrobe with three doors")                                                          \
    X(bookshelf, FLOOR, "book shelf, filled")                                                                \
    X(chest_of_drawers, FLOOR, "chest of drawers")                                                           \
    X(tv_board, FLOOR, "low board for a television")                                                         \
    X(kitchen, FLOOR, "kitchen unit with sink, hob and oven")                                                \
    X(wall_shelf, WALL, "wall shelf with vases")                                                             \
    X(tv, TOP, "television, off")                                                                            \
    X(tv_playing, TOP, "television, on: a textured light")                                                   \
    X(rug, FLOOR, "berber rug")                                                                              \
    X(round_rug, FLOOR, "round rug of jute")                                                                 \
    X(curtains, WALL, "curtains on a rod, y 0 is the floor")                                                 \
    X(cushion, TOP, "throw pillow, lying")                                                                   \
    X(monstera, FLOOR, "swiss cheese plant")                                                                 \
    X(fig_tree, FLOOR, "fiddle leaf fig")                                                                    \
    X(palm, FLOOR, "areca palm in a basket")                                                                 \
    X(picture, WALL, "print in an oak frame")                                                                \
    X(picture_trio, WALL, "three prints in black frames")                                                    \
    X(round_mirror, WALL, "round mirror")                                                                    \
    X(clock, WALL, "clock")                                                                                  \
    X(vase, TOP, "vase with twigs")                                                                          \
    X(bowl, TOP, "bowl of oranges")                                                                          \
    X(tea_set, TOP, "tray with pot and cups")                                                                \
    X(books, TOP, "stack of books")                                                                          \
    X(basket, FLOOR, "wicker basket with a blanket")                                                         \
    X(floor_lamp, FLOOR, "floor lamp: a mesh light in the shade")                                            \
    X(arc_lamp, FLOOR, "arc lamp: a disk light")                                                             \
    X(table_lamp, TOP, "table lamp with an opal globe: a sphere light")                                      \
    X(bedside_lamp, TOP, "bedside lamp: a mesh light in the shade")                                          \
    X(desk_lamp, TOP, "desk lamp: a spot light")                                                             \
    X(pendant, CEILING, "pendant lamp: a disk light")                                                        \
    X(globe_pendant, CEILING, "three opal globes: sphere lights")                                            \
    X(paper_lantern, CEILING, "paper lantern: a textured mesh light")                                        \
    X(ceiling_panel, CEILING, "ceiling panel: a rectangle light")                                            \
    X(spot_rail, CEILING, "rail of three spot lights")                                                       \
    X(wall_lamp, WALL, "wall lamp, up and down: two spot lights")

enum palette_piece {
#define X(name, where, what) PALETTE_##name,
    PALETTE(X)
#undef X
        PALETTE_COUNT
};

enum palette_where { PALETTE_FLOOR, PALETTE_TOP, PALETTE_WALL, PALETTE_CEILING };

struct palette_entry {
    const char *name, *what;
    enum palette_where where;
    void (*build)(struct furniture *p);
};

extern const struct palette_entry palette[PALETTE_COUNT];

// Builds the piece below `node` of a file that has the `looks`.
void palette_place(struct glb *g, struct looks *looks, enum palette_piece piece, int node);
// The piece as a file.
NG_NODISCARD ng_result palette_file(enum palette_piece piece, struct bytes *out);

#define X(name, where, what) void palette_##name(struct furniture *p);
PALETTE(X)
#undef X

#endif
