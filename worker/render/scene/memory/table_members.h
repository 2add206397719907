// The members of the tables of a scene, for HeapBytes. A list that leaves one out, or has one too many, does
// not compile.
#pragma once

#include <tuple>

#include "render/integrator/scene_tables.h"
#include "render/light/moving_lights.h"
#include "render/sensor/distortion_table.h"
#include "render/sensor/hole_table.h"
#include "render/sensor/lens_table.h"
#include "render/sensor/panorama_table.h"
#include "render/sensor/probe_table.h"
#include "render/sensor/shutter_table.h"

namespace tessera {

#define TESSERA_MEMBERS(Table, ...)         \
  inline auto members(const Table& table) { \
    const auto& [__VA_ARGS__] = table;      \
    return std::tie(__VA_ARGS__);           \
  }

namespace expression {
TESSERA_MEMBERS(Program, instructions, registers)
}  // namespace expression

namespace render {

// Geometry
TESSERA_MEMBERS(SdfGridRecord, render_from_object, object_from_render, size, smooth_normals, samples, voxels)
TESSERA_MEMBERS(CurvesRecord, kind, bspline, points, starts, normals, params, pieces, key_segments)
TESSERA_MEMBERS(ImplicitRecord, render_from_object, object_from_render, low, high, in_sphere, centre, radius,
                program, roots, lipschitz, cells, marked, degree, coefficients, magnitude, slope)
TESSERA_MEMBERS(CsgMesh, positions, triangles, order, nodes)
TESSERA_MEMBERS(CsgRecord, render_from_unit, unit_from_render, low, high, nodes, solids, meshes)
TESSERA_MEMBERS(ShapeTable, shapes, world_shape_count, objects, quadrics, facets, sdf_grids, curves,
                implicits, csgs, instances, inner, motion_steps, triangles, vertices)

// Matter
TESSERA_MEMBERS(MaterialTable, materials, extended, coat_tables, film_table, coat_offsets)
TESSERA_MEMBERS(MipPyramid, levels, texels16, texels32)
TESSERA_MEMBERS(TextureImage, width, height, format, texels8, texels32, decode, pyramid)
TESSERA_MEMBERS(TextureNode, kind, value, image, wrap, filter, max_anisotropy, invert, scale, channel,
                scale_u, scale_v, offset_u, offset_v, u_from_v, v_from_u, plain_uv, solid, source,
                texture_from_render, noise, octaves, roughness, variation, direction, attribute, inputs)
TESSERA_MEMBERS(MeshAttribute, channels, per_face, values)
TESSERA_MEMBERS(TextureTable, nodes, attribute_names, attributes, attribute_of_shape)
TESSERA_MEMBERS(DensityGrid, size, channels, grid_from_render, samples)
TESSERA_MEMBERS(MediumRecord, sigma_t, albedo, emission, g, scattering_is_sigma_s, emits, homogeneous,
                bounds_from_render, cells, majorants)
TESSERA_MEMBERS(MediumTable, media, grids)
TESSERA_MEMBERS(SpectralTables, coefficients, levels, ratios, curves, curve_of_light)

// Lights
TESSERA_MEMBERS(AliasTable, threshold, alias, pmf)
TESSERA_MEMBERS(Piecewise2d, width, height, marginal_cdf, conditional_cdf, density, marginal_guides,
                conditional_guides, marginal_guide, conditional_guide)
TESSERA_MEMBERS(LightTree, nodes, root_children, paths, unbounded, shares)
TESSERA_MEMBERS(Environment, mapping, light_from_render, render_from_light, width, height, texels,
                distribution, flux, sampled_share, portal, portal_area)
TESSERA_MEMBERS(LightTable, lights, environments, infinite_lights, selection, tree, uses_normals, sources,
                shapes, textures, any_textures, any_interpolated, scene_centre, scene_radius, moving)
TESSERA_MEMBERS(MovingLights, still, motion_of_light, motions, steps, moves)

// The view, and all of them
TESSERA_MEMBERS(SensitivityTable, quantiles, light, matter, from_nm, to_nm, bands, first_band_nm,
                bands_per_nm)
TESSERA_MEMBERS(Response, exposure, sensitivity)
TESSERA_MEMBERS(AperturePicture, density, transmission)
TESSERA_MEMBERS(GhostTable, part, selection, bounces, indices, per_etendue, rays_of_lights)
TESSERA_MEMBERS(LensTable, aperture, tilt, barrel_length, barrel_radius, picture, ghosts, surfaces,
                coefficients, edges, ratios, wavelengths, first_nm, wavelengths_per_nm, film_distance,
                units_per_mm, pupil_z, rings, cells_x, cells_y, cells_per_mm_x, cells_per_mm_y, first_x,
                first_y, pupil, weight)
TESSERA_MEMBERS(HoleTable, radius, spread, inward, weight, light, reach, wavelengths, first_nm,
                wavelengths_per_nm)
TESSERA_MEMBERS(DistortionTable, smooth, grid, nodes, start_grid, starts, slopes, near)
TESSERA_MEMBERS(ProbeTable, probes, probe_of_pixel, column_of_pixel, row_of_pixel, pixels, triangles,
                area_before_triangle)
TESSERA_MEMBERS(ShutterTable, knots, rows, from_last, across, duration)
TESSERA_MEMBERS(SensorRecord, kind, render_from_sensor, steps, shutter, scale_x, scale_y, offset_x, offset_y,
                circle_angle, lens_radius, focal_distance, lens, hole, distortion, panorama, probes,
                has_barrel, disperses, near_clip, far_clip, width, height, medium, response)
TESSERA_MEMBERS(FilterAxis, radius, cdf, weight)
TESSERA_MEMBERS(PixelFilterRecord, kind, x, y)
TESSERA_MEMBERS(LayerAutomaton, states, events, ends, begin, next, layers, shadows)
TESSERA_MEMBERS(LayerTable, count, tells_lobes, has_shadows, from_camera, from_lights, joined, unweighted,
                of_any_strategy, of_strategies, first_event_of_shape, source_of_light, one_source,
                source_of_media)
TESSERA_MEMBERS(OwnSettings::Value, name, number)
TESSERA_MEMBERS(OwnSettings, values)
TESSERA_MEMBERS(SceneTables, shapes, materials, textures, lights, media, spectral, sensor, footprint, filter,
                render_origin, sampler, max_depth, shared_caution, aovs, layers, own, irradiance_cache,
                radiosity, photon, metropolis, shading_group, shading_groups, any_textures, any_tangents,
                any_filtered, any_mix, any_opacity, paths_pass, volumetric, straight_shadows, any_motion,
                any_dispersion)

}  // namespace render

#undef TESSERA_MEMBERS

}  // namespace tessera
