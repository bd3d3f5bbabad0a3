// Compiled as C and as GLSL: what the shader computes is what the test expects.
#ifdef GL_core_profile
#define SHARED
#else
#include <stdint.h>
typedef uint32_t uint;
#define SHARED static inline
#endif

SHARED uint test_mix(uint x, uint add)
{
    x ^= x >> 15;
    x *= 2654435761u;
    return (x ^ (x >> 13)) + add;
}
