// A spiral: the angle of sample k is k times the golden angle, its u2 (k + 1/2) / count.
#include "lightformer/clues/brdf_samples.h"

const float lf_brdf_samples[LF_BRDF_SAMPLES][3] = {
    {1.0f, 0.0f, 0.03125f},
    {-0.737368878f, 0.675490294f, 0.09375f},
    {0.0874257247f, -0.996171041f, 0.15625f},
    {0.608438861f, 0.793600751f, 0.21875f},
    {-0.984713485f, -0.17418195f, 0.28125f},
    {0.843755295f, -0.536728053f, 0.34375f},
    {-0.259604305f, 0.965715074f, 0.40625f},
    {-0.460907025f, -0.887448429f, 0.46875f},
    {0.939321296f, 0.343038631f, 0.53125f},
    {-0.924345556f, 0.381556408f, 0.59375f},
    {0.423845995f, -0.905734273f, 0.65625f},
    {0.299283864f, 0.95416412f, 0.71875f},
    {-0.86521121f, -0.501407581f, 0.78125f},
    {0.976675774f, -0.214719429f, 0.84375f},
    {-0.575129429f, 0.81806243f, 0.90625f},
    {-0.12851069f, -0.991708124f, 0.96875f},
};

// By products, which are the same on every machine; cosf and sinf are not.
void lf_brdf_spiral(uint32_t count, float out[][3])
{
    const double cosine = -0.7373688780783197, sine = 0.6754902942615238; // of the golden angle
    double c = 1, s = 0;
    for (uint32_t i = 0; i < count; i++) {
        out[i][0] = (float)c;
        out[i][1] = (float)s;
        out[i][2] = ((float)i + 0.5f) / (float)count;
        double next = c * cosine - s * sine;
        s = c * sine + s * cosine;
        c = next;
    }
}
