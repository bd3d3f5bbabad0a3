// What compose.frag and tonemap.frag compute, on the host: for devices that draw on the CPU, where what is
// shown lies in host memory already. Plain C that the compiler vectorizes, built for several instruction
// sets; all give the same bytes, and those of the shaders within 1 of 255.
#ifndef NG_RENDER_DISPLAY_KERNELS_H
#define NG_RENDER_DISPLAY_KERNELS_H

#include "base/extern_c.h"
#include "shaders/shared/display.h"

#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

// [4] a pixel, as floats or as halfs; neither: black.
struct ng_display_map {
    const float *floats;
    const uint16_t *halfs;
};

struct ng_display_picture {
    struct ng_display_data shown;
    float exposure;
    struct ng_display_map left, left_divisor, right, right_divisor;
    struct ng_display_map position; // of the G-buffer; none: neither a background nor what is unlit is shown
    uint32_t width;                 // of a row
    uint8_t *out;                   // RGBA
};

struct ng_display_kernels {
    // The sum of three maps, for the pixels [begin, end); their fourth channel is 1.
    void (*compose)(const struct ng_display_map parts[3], size_t begin, size_t end, float *out);
    // `shown.cell` counts as 1.
    void (*show)(const struct ng_display_picture *picture, size_t begin, size_t end);
};

// The sets that this CPU has, the fastest first; null past the end.
const struct ng_display_kernels *ng_display_kernels_of(uint32_t index);

NG_EXTERN_C_END

#endif
