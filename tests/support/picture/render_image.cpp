#include "support/picture/render_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "image/assemble.h"
#include "wire/aov_channels.h"

namespace tessera::test {

client::Image render_image(const LoadedFile& file, std::uint64_t seed_offset,
                           const render::Prepared* prepared) {
  const std::uint32_t width = file.job.view().width(), height = file.job.view().height(),
                      spp = file.job.samples().spp();
  constexpr std::uint32_t kTile = 64;
  client::AssemblyOptions options;
  options.width = width;
  options.height = height;
  options.crop = {0, 0, static_cast<std::int32_t>(width), static_cast<std::int32_t>(height)};
  options.spp = spp;
  options.channels = wire::channels_of(file.job.view());
  auto assembler = client::Assembler::create(options);
  EXPECT_TRUE(assembler.ok()) << assembler.status();
  if (!assembler.ok()) return {};

  // Small films still give every core a tile.
  const std::uint32_t threads = std::max(1u, std::thread::hardware_concurrency());
  const std::uint32_t tile = std::min(kTile, (std::max(width, height) + 3) / 4);
  const std::uint32_t columns = (width + tile - 1) / tile, rows = (height + tile - 1) / tile;
  std::mutex mutex;
  std::atomic<std::uint32_t> next{0};
  std::atomic<bool> failed{false};
  const auto work = [&] {
    for (std::uint32_t i; (i = next.fetch_add(1)) < columns * rows;) {
      const std::uint32_t x = i % columns * tile, y = i / columns * tile;
      render::RenderStats stats;
      auto result = file.scene->render_tile(
          {x, y, std::min(x + tile, width), std::min(y + tile, height), 0, spp, seed_offset, prepared}, {},
          stats);
      const std::lock_guard lock(mutex);
      EXPECT_EQ(stats.dropped_samples, 0u);
      EXPECT_TRUE(result.ok()) << result.status();
      const absl::Status added = result.ok() ? assembler->add(*std::move(result)) : result.status();
      EXPECT_TRUE(added.ok()) << added;
      if (!added.ok()) failed = true;
    }
  };
  {
    std::vector<std::jthread> workers;
    for (std::uint32_t i = 0; i < threads; ++i) workers.emplace_back(work);
  }
  if (failed) return {};
  auto assembly = std::move(*assembler).finish();
  EXPECT_TRUE(assembly.ok()) << assembly.status();
  return assembly.ok() ? std::move(assembly->image) : client::Image{};
}

}  // namespace tessera::test
