"""What Mitsuba does not have: the project's BRDF and glTF's spot light, by their definitions (engine/README.md,
"Radiometry"; KHR_lights_punctual). Distribution, masking of one direction and sampling are Mitsuba's own.
"""

import drjit as dr
import mitsuba as mi

ROUGHNESS_MIN = 0.045
GRAZING = 1e-4  # the least cosine of the viewer


class MetallicRoughness(mi.BSDF):
    """(1 - F(v.h)) albedo / pi + D V F: GGX, height-correlated Smith, Schlick. Light passes only between directions
    that are above the geometric normal and above the shading normal; one-sided surfaces are black behind.

    base_color, metallic_roughness (G: roughness, B: metallic): textures; sides: 1 or 2.
    """

    def __init__(self, props):
        super().__init__(props)
        self.base_color = props.get_texture("base_color")
        self.metallic_roughness = props.get_texture("metallic_roughness")
        self.two_sided = props["sides"] == 2
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide
        if self.two_sided:
            flags |= mi.BSDFFlags.BackSide
        self.m_components = [flags]
        self.m_flags = flags

    def _place(self, si, active):
        """In the shading frame: 1 or -1, the side that is seen; the viewer as if above it; the geometric normal."""
        n = si.to_local(si.n)
        front = dr.dot(n, si.wi) > 0
        side = dr.select(front, mi.Float(1), mi.Float(-1))
        active = mi.Bool(active) & (mi.Bool(True) if self.two_sided else front)
        v = mi.Vector3f(si.wi.x, si.wi.y, side * si.wi.z)
        flat = dr.maximum(dr.sqrt(dr.square(v.x) + dr.square(v.y)), 1e-20)
        scale = dr.sqrt(1 - GRAZING * GRAZING) / flat
        v = dr.select(v.z < GRAZING, mi.Vector3f(v.x * scale, v.y * scale, GRAZING), v)
        return side, v, n, active

    def _material(self, si, active):
        base = self.base_color.eval(si, active)
        roughness_metallic = self.metallic_roughness.eval(si, active)
        metallic, roughness = roughness_metallic[2], dr.clip(roughness_metallic[1], ROUGHNESS_MIN, 1)
        albedo, f0 = base * (1 - metallic), dr.lerp(mi.Color3f(0.04), base, metallic)
        distribution = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, dr.square(roughness), sample_visible=True)
        return albedo, f0, distribution

    def _specular_share(self, albedo, f0, v):
        fresnel = dr.mean(f0 + (1 - f0) * (1 - v.z) ** 5)
        diffuse = dr.mean(albedo)
        return dr.clip(fresnel / dr.maximum(fresnel + diffuse, 1e-6), 0.2, dr.select(diffuse > 0, 0.8, 1))

    def _value_pdf(self, si, wo, active):
        side, v, n, active = self._place(si, active)
        l = mi.Vector3f(wo.x, wo.y, side * wo.z)
        active &= (l.z > 0) & (side * dr.dot(n, wo) > 0)
        albedo, f0, d = self._material(si, active)
        h = dr.normalize(v + l)
        fresnel = f0 + (1 - f0) * dr.maximum(1 - dr.dot(v, h), 0) ** 5
        # Mitsuba's G1 is 1 / (1 + Lambda); G2 = 1 / (1 + Lambda(v) + Lambda(l)).
        masking = 1 / (1 / d.smith_g1(v, h) + 1 / d.smith_g1(l, h) - 1)
        specular = fresnel * d.eval(h) * masking / (4 * v.z)
        value = (1 - fresnel) * albedo * l.z / dr.pi + specular
        share = self._specular_share(albedo, f0, v)
        pdf = share * d.pdf(v, h) / (4 * dr.dot(v, h)) + (1 - share) * l.z / dr.pi
        return dr.select(active, value, 0), dr.select(active, pdf, 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        side, v, n, active = self._place(si, active)
        albedo, f0, d = self._material(si, active)
        half, _ = d.sample(v, sample2)
        mirrored = half * (2 * dr.dot(v, half)) - v
        glossy = sample1 < self._specular_share(albedo, f0, v)
        l = dr.select(glossy, mirrored, mi.warp.square_to_cosine_hemisphere(sample2))
        bs = mi.BSDFSample3f(mi.Vector3f(l.x, l.y, side * l.z))
        value, bs.pdf = self._value_pdf(si, bs.wo, active)
        bs.eta = 1
        bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        bs.sampled_component = 0
        good = bs.pdf > 0
        return bs, dr.select(good, value / bs.pdf, 0)

    def eval(self, ctx, si, wo, active=True):
        return self._value_pdf(si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self._value_pdf(si, wo, active)[1]

    def eval_pdf(self, ctx, si, wo, active=True):
        return self._value_pdf(si, wo, active)

    def traverse(self, callback):
        callback.put_object("base_color", self.base_color, mi.ParamFlags.Differentiable)
        callback.put_object("metallic_roughness", self.metallic_roughness, mi.ParamFlags.Differentiable)

    def to_string(self):
        return "MetallicRoughness[]"


class Spot(mi.Emitter):
    """Intensity, falling between two angles by the square of a ramp in the cosine; along the placement's -Z."""

    def __init__(self, props):
        super().__init__(props)
        self.intensity = mi.Color3f(props["intensity"])
        matrix = props["to_world"].matrix
        self.position = mi.Point3f(*(matrix[i, 3] for i in range(3)))
        self.axis = dr.normalize(mi.Vector3f(*(-matrix[i, 2] for i in range(3))))
        self.cos_outer = dr.cos(props["outer"])
        self.ramp = max(0.001, dr.cos(props["inner"]) - self.cos_outer)
        self.m_flags = +mi.EmitterFlags.DeltaPosition

    def sample_direction(self, it, sample, active=True):
        ds = dr.zeros(mi.DirectionSample3f)
        ds.p, ds.n, ds.time, ds.pdf, ds.delta = self.position, 0, it.time, 1, True
        ds.emitter = mi.EmitterPtr(self)
        ds.d = ds.p - it.p
        ds.dist = dr.norm(ds.d)
        ds.d /= ds.dist
        t = dr.clip((-dr.dot(self.axis, ds.d) - self.cos_outer) / self.ramp, 0, 1)
        return ds, self.intensity * dr.square(t / ds.dist)

    def pdf_direction(self, it, ds, active=True):
        return mi.Float(0)

    def eval_direction(self, it, ds, active=True):
        return mi.Color3f(0)

    def eval(self, si, active=True):
        return mi.Color3f(0)

    def bbox(self):
        return mi.ScalarBoundingBox3f(mi.ScalarPoint3f(self.position.x[0], self.position.y[0], self.position.z[0]))

    def to_string(self):
        return "Spot[]"


mi.register_bsdf("metallic_roughness", MetallicRoughness)
mi.register_emitter("khr_spot", Spot)
