// The light of a photometric file as an image of all directions.
#pragma once

#include "photometry/lamps/luminaire.h"
#include "render/color/texture_table.h"

namespace tessera::render {

/// An equal-area octahedral map (sampling/sphere_map.h) of the intensities of a luminaire over their mean:
/// the mean of its texels, and with it that of what is looked up between them, is 1.
struct PhotometricMap {
  TextureImage image;
  double mean_candelas = 0;
};

/// Rows of the rotation of directions from the luminaire's space to that of its map: gamma 0 is in the middle
/// of the map. Its seams, where texels that touch each other on the sphere lie apart, are above the
/// horizontal and in no plane that files have.
extern const double kMapFromLuminaire[9];

/// A map that is fine enough that what is looked up is within 0.3 % of the intensities of the file in the
/// middle between its directions, up to 2048 x 2048 texels. Needs a sound table (photometry::fault_of()).
PhotometricMap build_photometric_map(const photometry::Luminaire& luminaire);

/// What a renderer looks up in the map, cd, in a direction of unit length of the luminaire's space.
double candelas_of_map(const PhotometricMap& map, double x, double y, double z);

}  // namespace tessera::render
