"""The scenes of content/ in Mitsuba 3: an independent renderer to hold the path tracer against.

    document = gltf.Document("content/unit/light_disk.glb")
    mean, variance = estimate.render(scene.build(document), document.camera(), (96, 96), 256)
"""

import mitsuba

mitsuba.set_variant("llvm_ad_rgb")  # compiled for this CPU; plugins in Python are compiled with the rest
