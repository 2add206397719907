#include "scheduler/work_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <functional>
#include <tuple>
#include <vector>

#include "wire/job_check.h"

namespace tessera::server {
namespace {

v1::JobSpec sound_spec() {
  v1::JobSpec spec;
  spec.mutable_view()->set_width(100);
  spec.mutable_view()->set_height(60);
  spec.mutable_cut()->mutable_crop()->set_x0(5);
  spec.mutable_cut()->mutable_crop()->set_y0(17);
  spec.mutable_cut()->mutable_crop()->set_x1(99);
  spec.mutable_cut()->mutable_crop()->set_y1(60);
  spec.mutable_cut()->set_tile_size(16);
  spec.mutable_cut()->set_samples_per_unit(8);
  spec.mutable_samples()->set_spp(21);
  spec.mutable_content()->set_scene(std::string(64, '0'));
  spec.mutable_farm()->add_blobs()->set_digest(spec.content().scene());
  return spec;
}

TEST(WorkPlan, TakesAStripOfAHundredThousandPixels) {
  v1::JobSpec spec = sound_spec();
  spec.mutable_view()->set_width(100'000), spec.mutable_view()->set_height(1);
  *spec.mutable_cut()->mutable_crop() = {};
  spec.mutable_cut()->mutable_crop()->set_x1(100'000);
  spec.mutable_cut()->mutable_crop()->set_y1(1);
  EXPECT_TRUE(WorkPlan::make(spec).ok()) << WorkPlan::make(spec).status();
}

TEST(WorkPlan, CoversEveryPixelAndSampleOnce) {
  const v1::JobSpec spec = sound_spec();
  const WorkPlan plan = WorkPlan::make(spec).value();
  std::vector<int> seen(spec.view().width() * spec.view().height());
  for (std::uint32_t i = 0; i < plan.unit_count(); ++i) {
    const v1::WorkUnit unit = plan.unit(i);
    EXPECT_EQ(unit.index(), i);
    const v1::PixelRect& pixels = unit.tile().pixels();
    EXPECT_EQ(pixels.x0() / 16, (pixels.x1() - 1) / 16) << "a tile lies within one cell of the grid";
    EXPECT_EQ(pixels.y0() / 16, (pixels.y1() - 1) / 16);
    const int samples = static_cast<int>(unit.tile().samples().end() - unit.tile().samples().begin());
    for (std::uint32_t y = pixels.y0(); y < pixels.y1(); ++y) {
      for (std::uint32_t x = pixels.x0(); x < pixels.x1(); ++x) seen[y * spec.view().width() + x] += samples;
    }
  }
  for (std::uint32_t y = 0; y < spec.view().height(); ++y) {
    for (std::uint32_t x = 0; x < spec.view().width(); ++x) {
      const bool inside = x >= 5 && x < 99 && y >= 17;
      ASSERT_EQ(seen[y * spec.view().width() + x], inside ? 21 : 0) << x << ", " << y;
    }
  }
}

TEST(WorkPlan, EachViewHasAllTilesAndRanges) {
  v1::JobSpec spec = sound_spec();
  const WorkPlan one = WorkPlan::make(spec).value();
  spec.mutable_cut()->set_views(3);
  const WorkPlan plan = WorkPlan::make(spec).value();
  ASSERT_EQ(plan.unit_count(), 3 * one.unit_count());
  for (std::uint32_t i = 0; i < plan.unit_count(); ++i) {
    const std::uint32_t range = i / plan.tile_count(), view = i % plan.tile_count() / one.tile_count(),
                        tile = i % one.tile_count();
    const v1::WorkUnit unit = plan.unit(i);
    EXPECT_EQ(unit.tile().view(), view);
    v1::TileUnit expected = one.unit(range * one.tile_count() + tile).tile();
    expected.set_view(view);
    EXPECT_EQ(unit.tile().SerializeAsString(), expected.SerializeAsString()) << i;
    EXPECT_EQ(extent_of(unit, spec).view(), view);
  }
  EXPECT_EQ(plan.longest_run(5).step, plan.tile_count());
  spec.mutable_content()->mutable_algorithms()->set_integrator("light");
  const WorkPlan passes = WorkPlan::make(spec).value();
  for (std::uint32_t i = 0; i < passes.unit_count(); ++i) {
    EXPECT_EQ(passes.unit(i).pass().view(), i % 3);
    EXPECT_EQ(extent_of(passes.unit(i), spec).view(), i % 3);
  }
}

TEST(WorkPlan, ViewsWhoseUnitsAreTooManyAreRefused) {
  v1::JobSpec spec = sound_spec();
  for (const std::uint32_t views : {1u << 24, ~0u}) {
    spec.mutable_cut()->set_views(views);
    const absl::Status status = WorkPlan::make(spec).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_THAT(std::string(status.message()), testing::HasSubstr(" views times "));
  }
}

TEST(WorkPlan, RangesAreNodesOfTheSumTreeAndComeInOrder) {
  const WorkPlan plan = WorkPlan::make(sound_spec()).value();
  std::uint32_t last_begin = 0;
  for (std::uint32_t i = 0; i < plan.unit_count(); ++i) {
    const v1::SampleRange samples = plan.unit(i).tile().samples();
    EXPECT_EQ(samples.begin() % std::bit_ceil(samples.end() - samples.begin()), 0u);
    EXPECT_GE(samples.begin(), last_begin) << "no tile gets its second range before all have their first";
    last_begin = samples.begin();
  }
  EXPECT_EQ(last_begin, 16u);
}

TEST(WorkPlan, RunsAreNodesOfTheSumTree) {
  v1::JobSpec spec = sound_spec();
  spec.mutable_samples()->set_spp(8 * 13 + 5);  // thirteen whole ranges, and one of five samples
  const WorkPlan plan = WorkPlan::make(spec).value();
  const std::uint32_t tiles = plan.unit_count() / 14;
  const std::uint32_t longest[] = {8, 1, 2, 1, 4, 1, 2, 1, 4, 1, 2, 1, 1, 1};
  for (std::uint32_t range = 0; range < 14; ++range) {
    const UnitRun run = plan.longest_run(range * tiles + 3);
    EXPECT_EQ(run.count, longest[range]) << "from range " << range;
    EXPECT_EQ(plan.begins_tile(run.first), range == 0);
    const v1::TileUnit tile = plan.unit(run).tile();
    EXPECT_EQ(tile.samples().begin(), 8 * range);
    EXPECT_EQ(tile.samples().end(), std::min(8 * (range + run.count), 8u * 13 + 5));
    EXPECT_EQ(plan.unit(run).index(), run.first);
    for (const std::uint32_t unit : run) {
      EXPECT_EQ(plan.unit(unit).tile().pixels().x0(), tile.pixels().x0());
      EXPECT_EQ(plan.unit(unit).tile().pixels().y0(), tile.pixels().y0());
    }
    EXPECT_EQ(plan.run(run.first, run.count), run);
    EXPECT_EQ(plan.run(run.first, 2 * run.count), std::nullopt);
  }
  EXPECT_EQ(plan.run(0, 3), std::nullopt);
  EXPECT_EQ(plan.run(0, 0), std::nullopt);
  EXPECT_EQ(plan.run(plan.unit_count(), 1), std::nullopt);
}

TEST(WorkPlan, PassesRunAlike) {
  v1::JobSpec spec = sound_spec();
  spec.mutable_content()->mutable_algorithms()->set_integrator("light");
  const WorkPlan plan = WorkPlan::make(spec).value();
  ASSERT_EQ(plan.unit_count(), 3u);
  EXPECT_EQ(plan.longest_run(0), (UnitRun{.first = 0, .count = 2, .step = 1}));
  EXPECT_EQ(plan.unit(plan.longest_run(0)).pass().passes().end(), 16u);
}

TEST(WorkPlan, BeginsInTheMiddle) {
  v1::JobSpec spec = sound_spec();
  spec.mutable_cut()->mutable_crop()->set_x0(0);
  spec.mutable_cut()->mutable_crop()->set_y0(0);
  spec.mutable_cut()->mutable_crop()->set_x1(80);
  spec.mutable_cut()->mutable_crop()->set_y1(48);  // 5 x 3 tiles
  const WorkPlan plan = WorkPlan::make(spec).value();
  EXPECT_EQ(plan.unit(0).tile().pixels().x0(), 32u);
  EXPECT_EQ(plan.unit(0).tile().pixels().y0(), 16u);
  int last_ring = 0;
  for (std::uint32_t i = 0; i < 15; ++i) {
    const v1::PixelRect pixels = plan.unit(i).tile().pixels();
    const int dx = static_cast<int>(pixels.x0() / 16) - 2, dy = static_cast<int>(pixels.y0() / 16) - 1;
    const int ring = std::max(std::abs(dx), std::abs(dy));
    EXPECT_GE(ring, last_ring);
    last_ring = ring;
  }
}

TEST(TileOrder, IsThatOfRingsRoundTheMiddleClockwise) {
  constexpr int kMost = 9;
  for (int columns = 1; columns <= kMost; ++columns) {
    for (int rows = 1; rows <= kMost; ++rows) {
      // Every tile with its ring, and how far along the ring it is.
      std::vector<std::tuple<int, int, int, int>> expected;
      for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
          const int x = 2 * column - (columns - 1), y = 2 * row - (rows - 1);
          const int ring = std::max(std::abs(x), std::abs(y));
          const int along = y == -ring  ? x + ring
                            : x == ring ? 3 * ring + y
                            : y == ring ? 5 * ring - x
                                        : 7 * ring - y;
          expected.emplace_back(ring, along, column, row);
        }
      }
      std::ranges::sort(expected);
      const TileOrder order(static_cast<std::uint32_t>(columns), static_cast<std::uint32_t>(rows));
      ASSERT_EQ(order.count(), expected.size());
      for (std::uint32_t i = 0; i < order.count(); ++i) {
        const TileOrder::Tile tile = order.tile(i);
        ASSERT_EQ(static_cast<int>(tile.column), std::get<2>(expected[i]))
            << columns << " x " << rows << ": " << i;
        ASSERT_EQ(static_cast<int>(tile.row), std::get<3>(expected[i]))
            << columns << " x " << rows << ": " << i;
      }
    }
  }
}

TEST(TileOrder, EndsInACornerOfTheLargestGrid) {
  const TileOrder order(4096, 4096);
  EXPECT_EQ(order.count(), 1u << 24);
  const TileOrder::Tile last = order.tile(order.count() - 1);
  EXPECT_EQ(last.column, 0u);
  EXPECT_EQ(last.row, 1u) << "the corner itself is where the ring began";
}

TEST(WorkPlan, LightTracingWorksInPassesOverTheCrop) {
  v1::JobSpec spec = sound_spec();
  spec.mutable_content()->mutable_algorithms()->set_integrator("light");
  const WorkPlan plan = WorkPlan::make(spec).value();
  ASSERT_EQ(plan.unit_count(), 3u);
  std::uint32_t next = 0;
  for (std::uint32_t i = 0; i < plan.unit_count(); ++i) {
    const v1::WorkUnit unit = plan.unit(i);
    ASSERT_TRUE(unit.has_pass());
    const v1::TileUnit extent = extent_of(unit, spec);
    EXPECT_EQ(extent.pixels().SerializeAsString(), spec.cut().crop().SerializeAsString());
    EXPECT_EQ(extent.samples().begin(), next);
    next = extent.samples().end();
  }
  EXPECT_EQ(next, 21u);

  // A pass must fit a message: 96 MiB, five words a pixel.
  for (const std::uint32_t height : {1200u, 1300u}) {
    spec.mutable_view()->set_width(4000), spec.mutable_view()->set_height(height);
    spec.mutable_cut()->mutable_crop()->set_x0(0), spec.mutable_cut()->mutable_crop()->set_y0(0);
    spec.mutable_cut()->mutable_crop()->set_x1(4000), spec.mutable_cut()->mutable_crop()->set_y1(height);
    EXPECT_EQ(WorkPlan::make(spec).ok(), height == 1200u) << height;
  }
}

TEST(WorkPlan, NamesTheFieldThatIsUnsound) {
  const auto message = [](const std::function<void(v1::JobSpec&)>& spoil) {
    v1::JobSpec spec = sound_spec();
    spoil(spec);
    const auto plan = WorkPlan::make(spec);
    EXPECT_EQ(plan.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(plan.status().message());
  };
  using testing::HasSubstr;
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_view()->set_width(0); }), HasSubstr("width"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_view()->set_width(1'000'001); }), HasSubstr("width"));
  EXPECT_THAT(message([](v1::JobSpec& s) {
                s.mutable_view()->set_width(65537);
                s.mutable_view()->set_height(65536);
              }),
              HasSubstr("width"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_view()->set_height(1u << 20); }), HasSubstr("height"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->mutable_crop()->set_x1(101); }),
              HasSubstr("crop"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->mutable_crop()->set_y0(60); }),
              HasSubstr("crop"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->set_tile_size(0); }), HasSubstr("tile_size"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->set_tile_size(5000); }), HasSubstr("tile_size"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->set_samples_per_unit(12); }),
              HasSubstr("samples_per_unit"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_cut()->set_samples_per_unit(0); }),
              HasSubstr("samples_per_unit"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_samples()->set_spp(0); }), HasSubstr("spp"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_content()->set_scene("../../etc/passwd"); }),
              HasSubstr("scene"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_farm()->add_blobs()->set_path("a.ply"); }),
              HasSubstr("a.ply"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_view()->add_aovs(static_cast<v1::AOV>(77)); }),
              HasSubstr("aovs is number 77"));
  EXPECT_THAT(message([](v1::JobSpec& s) {
                for (int i = 0; i < 2; ++i) s.mutable_view()->add_aovs(v1::AOV_DEPTH);
              }),
              HasSubstr("ascending order, each once"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.mutable_farm()->clear_blobs(); }),
              HasSubstr("its scene is not among its blobs"));
  EXPECT_THAT(message([](v1::JobSpec& s) { s.clear_content(); }), HasSubstr("client of another version"));
  EXPECT_THAT(message([](v1::JobSpec& s) {
                s.mutable_farm()->mutable_auto_choice()->set_reason(std::string(100'000, 'a'));
              }),
              HasSubstr("how its integrator was chosen"));
  EXPECT_THAT(message([](v1::JobSpec& s) {
                for (int i = 0; i < 1000; ++i) s.mutable_farm()->mutable_auto_choice()->add_candidates();
              }),
              HasSubstr("how its integrator was chosen"));
  // With noise, a unit has all samples of its pixels.
  const auto noisy = [&](const std::function<void(v1::JobSpec&)>& spoil) {
    return message([&](v1::JobSpec& s) {
      s.mutable_samples()->set_noise(0.05);
      s.mutable_cut()->set_samples_per_unit(32);
      wire::add_phases(s);
      spoil(s);
    });
  };
  EXPECT_THAT(noisy([](v1::JobSpec& s) { s.mutable_samples()->set_noise(1.5); }), HasSubstr("noise is 1.5"));
  EXPECT_THAT(noisy([](v1::JobSpec& s) { s.mutable_samples()->set_spp(7); }), HasSubstr("8 or more"));
  EXPECT_THAT(noisy([](v1::JobSpec& s) { s.mutable_cut()->set_samples_per_unit(16); }),
              HasSubstr("samples_per_unit"));
  EXPECT_THAT(
      noisy([](v1::JobSpec& s) { s.mutable_content()->mutable_algorithms()->set_integrator("light"); }),
      HasSubstr("same samples everywhere"));
  EXPECT_THAT(
      message([](v1::JobSpec& s) { s.mutable_content()->mutable_algorithms()->set_integrator("nosuch"); }),
      HasSubstr("there is no integrator 'nosuch'"));
  const std::string text(5000, 'x');
  EXPECT_THAT(message([&](v1::JobSpec& s) { s.mutable_farm()->set_user(text); }), HasSubstr("too long"));
  EXPECT_THAT(
      message([&](v1::JobSpec& s) { s.mutable_content()->mutable_algorithms()->set_integrator(text); }),
      HasSubstr("too long"));
  EXPECT_THAT(message([&](v1::JobSpec& s) {
                for (int i = 0; i < 5000; ++i) s.mutable_farm()->add_required_tags("");
              }),
              HasSubstr("too long"));
  EXPECT_THAT(message([](v1::JobSpec& s) {
                s.mutable_view()->set_width(65536);
                s.mutable_view()->set_height(65536);
                s.mutable_cut()->mutable_crop()->set_x1(65536);
                s.mutable_cut()->mutable_crop()->set_y1(65536);
                s.mutable_cut()->set_tile_size(1);
              }),
              HasSubstr("units"));
}

}  // namespace
}  // namespace tessera::server
