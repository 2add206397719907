// Cryptomatte: which things a pixel shows, and how much of it each of them covers [Friedman2015; the
// specification, version 1.2].
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "image/image.h"

namespace tessera::client {

/// MurmurHash3_x86_32 of a name, with seed 0 [Appleby 2011].
std::uint32_t matte_hash(std::string_view name);
/// The hash as a pixel's value: its bits, with the lowest of the exponent turned round where the number would
/// be none, infinite or denormal.
float matte_identifier(std::string_view name);

inline constexpr std::uint32_t kMatteRanks = 6;

/// Turns a list of identifiers as results have it (wire::ChannelKind::kEntry: channels "LIST.id0",
/// "LIST.weight0" ...) into the channels and metadata of Cryptomatte `name`: the things of the largest
/// coverages, `ranks` of them, two to each of the layers NAME00, NAME01 ... `name_of` names what a number
/// stands for; things of one name are one. Nothing where the image has no such list.
void resolve_mattes(std::string_view list, const std::string& name, std::uint32_t ranks,
                    const std::function<std::string(std::int64_t)>& name_of, Image& image);

}  // namespace tessera::client
