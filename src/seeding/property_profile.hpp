#pragma once
// A property over depth or place (ProfileSpec), of each particle where it begins:
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

/// Gives a property a profile, or another one: the material's law becomes the one that keeps all that vary per particle
/// (core/material/over_depth.hpp). Throws std::logic_error where there is none.
void set_profile(MaterialSpec& material, std::size_t property, ProfileSpec profile);

/// The law as above by the profiles and keeps_strength that the material has.
void choose_law_over_depth(MaterialSpec& material);

/// Whether the body has a surface of its own: tables of particles and inflows have none.
bool has_surface(const BodySpec& body);

/// z of a particle of the body that begins at x [m]. The body has a surface, or the profile a height.
double depth_at(const Scene& scene, const BodySpec& body, const ProfileSpec& profile, const Triple& x);

/// s there [unit of the property]; NaN where a raster knows none.
double profile_at(const Scene& scene, const BodySpec& body, const ProfileSpec& profile, const Triple& x);

/// rho0 of a particle of the body that begins at x [kg/m3].
double density_at(const Scene& scene, const BodySpec& body, const Triple& x);

/// Integral of rho0 upwards from x over a height, exact, with the profile's value at no depth above the surface
/// [kg/m2].
double mass_above(const Scene& scene, const BodySpec& body, const Triple& x, double height);

/// Of all particles of a body.
struct ProfileRange {
    double least = 0, most = 0;  ///< NaN: of a particle there is none
    Triple where{};              ///< the particle of the least, or the first that has none [m]
};

/// Goes through the particles of a body. Throws InputError if its table is bad.
ProfileRange profile_range(const Scene& scene, int body, const ProfileSpec& profile);

/// Bounds of a profile in all bodies of a material, by their extents.
ProfileRange profile_bounds(const Scene& scene, int material, const ProfileSpec& profile);

}  // namespace moraine
