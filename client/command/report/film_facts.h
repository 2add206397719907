// Facts that an image file tells of the sensor that saw it, and of its bands.
#pragma once

#include "image/image.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

/// The attributes "chromaticities" where the picture is in another space than Rec.709, or
/// "tessera.raw_channels" where it is in none; "adoptedNeutral" and "cameraCCTSetting" where it was balanced
/// for a white; "tessera.sensor" and "tessera.white_balance" of light of
/// wavelengths; and of bands "tessera.film", and those of spectral OpenEXR files [Fichet, Pacanowski & Wilkie
/// 2021].
void add_film_facts(const v1::JobSpec& spec, Image& image);

}  // namespace tessera::client
