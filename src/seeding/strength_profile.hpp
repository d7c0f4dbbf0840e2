#pragma once
// A strength over depth or place (StrengthSpec), of each particle where it begins:
//
//   s(z) = surface + gradient z, or a table linear between its rows and constant beyond; surface: a number, or a raster
//
// z: depth along gravity (without it, along the last axis) [m], at least 0, below the body's surface or below a height
// of the scene. The surface is where the line up from the particle leaves the body for good: a polygon's or sphere's
// outline, and of a layer the plane that it has above the particle, at T over the ground. Of a box it is the plane of
// its upper face, also where gravity leans: ends of a box are cuts through soil that goes on.
//
// It is a function of the scene and the place alone, so any rank may ask it of any particle.

#include <cstddef>

#include "core/scene_spec.hpp"

namespace moraine {

/// Gives the material's parameter a profile: its law becomes the one that keeps it per particle
/// (core/material/over_depth.hpp). Throws std::logic_error where there is none.
void set_profile(MaterialSpec& material, std::size_t parameter, StrengthSpec profile);

/// Whether the body has a surface of its own: tables of particles and inflows have none.
bool has_surface(const BodySpec& body);

/// z of a particle of the body that begins at x [m]. The body has a surface, or the profile a height.
double depth_at(const Scene& scene, const BodySpec& body, const StrengthSpec& profile, const Triple& x);

/// s there, of the body's material, which has a profile [unit of the parameter]; NaN where a raster knows none.
double strength_at(const Scene& scene, const BodySpec& body, const Triple& x);

/// Of all particles of a body.
struct StrengthRange {
    double least = 0, most = 0;  ///< NaN: of a particle there is none
    Triple where{};              ///< the particle of the least, or the first that has none [m]
};

/// Goes through the particles of a body whose material has a profile. Throws InputError if its table is bad.
StrengthRange strength_range(const Scene& scene, int body);

}  // namespace moraine
