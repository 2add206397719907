#include "support/picture/phases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <span>
#include <thread>
#include <utility>

#include "base/cpu_time.h"

namespace tessera::test {

namespace {

std::shared_ptr<const render::Prepared> prepare(const LoadedFile& file,
                                                const std::vector<std::string>& blobs) {
  const std::vector<std::string_view> views(blobs.begin(), blobs.end());
  auto prepared = file.scene->prepare(views);
  EXPECT_TRUE(prepared.ok()) << prepared.status();
  return prepared.ok() ? *prepared : nullptr;
}

}  // namespace

MadePhases make_phases(const LoadedFile& file, const PhaseMaking& how) {
  MadePhases made;
  for (int p = 0; p < file.job.cut().phases_size(); ++p) {
    const v1::Phase& phase = file.job.cut().phases(p);
    std::vector<std::string> blobs(phase.parts());
    std::atomic<std::uint32_t> next{0};
    std::mutex mutex;
    const auto work = [&] {
      const std::chrono::nanoseconds start = base::thread_cpu_time();
      for (std::uint32_t i; (i = next.fetch_add(1)) < phase.parts();) {
        const std::uint32_t part = how.from_the_last ? phase.parts() - 1 - i : i;
        render::RenderStats stats;
        auto blob = file.scene->make_part(
            {static_cast<std::uint32_t>(p), part, phase.parts(), made.prepared.get()}, {}, {}, stats);
        EXPECT_TRUE(blob.ok()) << blob.status();
        if (blob.ok()) blobs[part] = *std::move(blob);
      }
      const std::lock_guard lock(mutex);
      made.cpu_seconds += base::in_seconds(base::thread_cpu_time() - start);
    };
    {
      const unsigned threads = how.threads > 0 ? static_cast<unsigned>(how.threads)
                                               : std::max(1u, std::thread::hardware_concurrency());
      std::vector<std::jthread> workers;
      for (unsigned i = 0; i < threads; ++i) workers.emplace_back(work);
    }
    const std::size_t width = how.merge_width > 0 ? how.merge_width : phase.merge_width();
    while (blobs.size() > 1) {
      std::vector<std::string> merged;
      for (std::size_t i = 0; i < blobs.size(); i += width) {
        const std::size_t n = std::min(width, blobs.size() - i);
        const std::vector<std::string_view> group(blobs.begin() + static_cast<std::ptrdiff_t>(i),
                                                  blobs.begin() + static_cast<std::ptrdiff_t>(i + n));
        auto one = file.scene->merge(static_cast<std::uint32_t>(p), group);
        EXPECT_TRUE(one.ok()) << one.status();
        merged.push_back(one.ok() ? *std::move(one) : "");
      }
      blobs = std::move(merged);
    }
    made.blobs.push_back(std::move(blobs.front()));
    made.prepared = prepare(file, made.blobs);
  }
  return made;
}

MadePhases expect_one_result(const LoadedFile& file, std::uint32_t side) {
  MadePhases usual = make_phases(file, {.threads = 1});
  for (const PhaseMaking& how : {PhaseMaking{.threads = 3}, PhaseMaking{.threads = 2, .from_the_last = true},
                                 PhaseMaking{.merge_width = 2}, PhaseMaking{.merge_width = 64}})
    EXPECT_EQ(make_phases(file, how).blobs, usual.blobs);
  const auto render = [&](render::TileRequest tile) {
    render::RenderStats stats;
    tile.sample_end = 4, tile.prepared = usual.prepared.get();
    return file.scene->render_tile(tile, {}, stats)->values;
  };
  const std::uint32_t x0 = side / 3, y0 = side / 2, width = side / 4 + 1, height = side / 5;
  const std::vector<float> whole = render({.x1 = side, .y1 = side}),
                           part = render({x0, y0, x0 + width, y0 + height});
  for (std::uint32_t c = 0; c < 3; ++c) {
    for (std::uint32_t y = 0; y < height; ++y) {
      for (std::uint32_t x = 0; x < width; ++x) {
        EXPECT_EQ(part[(c * height + y) * width + x], whole[(c * side + y0 + y) * side + x0 + x])
            << x << " " << y;
      }
    }
  }
  return usual;
}

}  // namespace tessera::test
