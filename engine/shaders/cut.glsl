// Holes of alpha masks, and surfaces that cover a part of what is behind them.
#include "shared/coverage.h"

// Whether this fragment is not there. `alpha`, of the texture, was read from `level`; `factor` multiplies it.
bool is_cut(ng_material_data m, ng_instance_data instance, bool front, float alpha, float level, float factor)
{
    if ((m.flags & (NG_MATERIAL_MASK | NG_MATERIAL_BLEND)) == 0)
        return false;
    uint surface = 2 * instance.entity + (front ? 1 : 0);
    float threshold = ng_coverage_threshold(uint(gl_FragCoord.x), uint(gl_FragCoord.y), surface, instance.subpixel) + 0.5 * NG_COVERAGE_STEP;
    if ((m.flags & NG_MATERIAL_BLEND) != 0)
        return alpha * factor < threshold;
    // Smaller levels hold the mean, of a mask about the share of texels that are there: where texels are smaller than pixels, the same
    // share of pixels is drawn (after Wyman and McGuire, "Hashed alpha testing", 2017), so that leaves do not vanish with
    // distance.
    float cutoff = m.alpha_cutoff / max(factor, 1e-6);
    return factor < m.alpha_cutoff || alpha < mix(cutoff, threshold, clamp(level, 0.0, 1.0));
}
