// Caps that all three programs hold each other to.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tessera::wire {

/// Largest RPC message, either way. A tile of kMaxTileSize squared with every AOV fits.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{96} << 20;

/// Largest piece of a blob in one Upload or Download message.
inline constexpr std::size_t kBlobChunkBytes = std::size_t{1} << 20;

/// Largest blob.
inline constexpr std::uint64_t kMaxBlobBytes = std::uint64_t{64} << 30;

/// Most blobs in one FindMissing call.
inline constexpr int kMaxFindMissing = 10000;

/// Most blobs that one job refers to.
inline constexpr int kMaxBlobsPerJob = 1 << 18;

/// Most jobs that one job waits for (JobSpec.Farm.after).
inline constexpr int kMaxAfter = 64;

/// Largest side of a tile, pixels.
inline constexpr std::uint32_t kMaxTileSize = 1024;

/// Most samples a pixel.
inline constexpr std::uint32_t kMaxSamplesPerPixel = std::uint32_t{1} << 24;

/// Most scattering events on a path; whoever asks for more gets these. The dimensions of samples and the keys
/// of number streams are laid out for them (worker/render/sampling/sampler_config.h).
inline constexpr std::uint32_t kMaxDepth = (1u << 15) - 1;

/// Where samples are taken as noise asks for (RenderSettings.noise): fewest samples a pixel, and the side of
/// the blocks that are decided on together.
inline constexpr std::uint32_t kLeastNoiseSamples = 8;
inline constexpr std::uint32_t kNoiseBlock = 8;

/// Largest radius of a pixel filter with which samples go into several pixels, pixels: tiles are rendered
/// with a border of that width.
inline constexpr float kMaxScatterRadius = 16;

/// ImageTexture.max_anisotropy
inline constexpr float kMaxAnisotropy = 64;

/// Settings of irradiance caches (RenderSettings.irradiance_cache).
inline constexpr std::uint32_t kLeastCacheSamples = 16;
inline constexpr std::uint32_t kMostGlossyBands = 12;

/// Most phases of one job, parts of one phase, and blobs that are merged at a time.
inline constexpr int kMaxPhases = 64;
inline constexpr std::uint32_t kMaxPartsPerPhase = std::uint32_t{1} << 20;
inline constexpr std::uint32_t kMaxMergeWidth = 64;

/// Most units of one job.
inline constexpr std::uint64_t kMaxUnitsPerJob = std::uint64_t{1} << 24;

/// Most units in one Lease call, and most leases that one worker may hold.
inline constexpr std::uint32_t kMaxLeasesPerCall = 256;
inline constexpr std::uint32_t kMaxLeasesPerWorker = 4096;

/// Longest wait of a Lease call, seconds; longer ones are answered with nothing after this time.
inline constexpr int kMaxLeaseWaitSeconds = 30;

/// Most textures, and mixed materials, within one another; and most look-ups that one texture may take, all
/// that it is made of included: a few hundred lines could name billions otherwise.
inline constexpr int kMaxNesting = 64;
inline constexpr double kMaxTextureLookups = 4096;

/// Most characters in a name, an error message or a warning that one program keeps for another.
inline constexpr std::size_t kMaxTextBytes = 4096;

}  // namespace tessera::wire
