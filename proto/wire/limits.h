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

/// Where samples are taken as noise asks for (RenderSettings.noise): fewest samples a pixel, smallest and
/// largest error, and the side of the blocks that are decided on together.
inline constexpr std::uint32_t kLeastNoiseSamples = 8;
inline constexpr double kMinNoise = 1e-4;
inline constexpr double kMaxNoise = 1;
inline constexpr std::uint32_t kNoiseBlock = 8;

/// Largest radius of a pixel filter with which samples go into several pixels, pixels: tiles are rendered
/// with a border of that width.
inline constexpr float kMaxScatterRadius = 16;

/// RenderSettings.texture_footprint
inline constexpr double kMaxTextureFootprint = 16;
inline constexpr double kDefaultTextureFootprint = 0.125;  // pbrt's, from 64 samples a pixel on

/// ImageTexture.max_anisotropy
inline constexpr float kMaxAnisotropy = 64;

/// RenderSettings.grid_density
inline constexpr double kMinGridDensity = 1e-3;
inline constexpr double kMaxGridDensity = 1e4;

/// Settings of irradiance caches (RenderSettings.irradiance_cache).
inline constexpr double kLeastCacheError = 0.01, kMostCacheError = 1;
inline constexpr std::uint32_t kLeastCacheSamples = 16, kMostCacheSamples = 65536;
inline constexpr double kLeastCacheReach = 0.5, kMostCacheReach = 10000;  // widths of a pixel
inline constexpr std::uint32_t kLeastGlossyBands = 2, kMostGlossyBands = 12;
/// Largest factor of a preview's ambient light.
inline constexpr double kMaxAmbient = 1000;

/// Light paths of a pass that are asked for (PhotonSettings): most of them; and the radius in the scene's
/// units.
inline constexpr std::uint64_t kMaxPhotons = std::uint64_t{1} << 30;
inline constexpr double kMinPhotonRadius = 1e-15;
inline constexpr double kMaxPhotonRadius = 1e15;

/// Settings of integrators that mutate paths (MetropolisSettings).
inline constexpr std::uint32_t kMaxMutations = std::uint32_t{1} << 20;
inline constexpr std::uint32_t kMaxCandidates = 4096;
inline constexpr double kMinLargeSteps = 0.01;
inline constexpr double kMinStep = 1e-6, kMaxStep = 0.5;

/// GuidingSettings.samples
inline constexpr double kLeastGuidingSamples = 0.01, kMostGuidingSamples = 1024;

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
