// C linkage for a header's declarations where C++ includes it: they stand between these two.
#ifndef NG_BASE_EXTERN_C_H
#define NG_BASE_EXTERN_C_H

#ifdef __cplusplus
#define NG_EXTERN_C_BEGIN extern "C" {
#define NG_EXTERN_C_END   }
#else
#define NG_EXTERN_C_BEGIN
#define NG_EXTERN_C_END
#endif

#endif
