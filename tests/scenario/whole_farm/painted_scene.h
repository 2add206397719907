// A scene whose pixels are arithmetic: quick to render, and everybody knows what is right.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "render/renderer.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/work.pb.h"

namespace tessera::test {

class PaintedScene final : public render::RenderScene {
 public:
  /// Things that happen to whoever renders it; their errors are the unit's.
  struct Events {
    std::function<absl::Status(std::stop_token stop)> work;  // done for each unit
    std::function<absl::Status()> read;                      // blobs of phases
  };

  /// `rounding` stands for an arithmetic class: pictures of another are others.
  PaintedScene(const v1::JobSpec& spec, std::uint64_t rounding, Events events);

  absl::StatusOr<wire::TileResult> render_tile(const render::TileRequest& tile, std::stop_token stop,
                                               render::RenderStats& stats) const override;
  absl::StatusOr<std::shared_ptr<const render::Prepared>> prepare(
      std::span<const std::string_view> blobs) const override;
  absl::StatusOr<std::string> make_part(const render::PartRequest& part, const render::FilmRect& crop,
                                        std::stop_token stop, render::RenderStats& stats) const override;
  absl::StatusOr<std::string> merge(std::uint32_t phase,
                                    std::span<const std::string_view> blobs) const override;
  const std::vector<std::string>& warnings() const override { return none_; }
  const std::vector<std::string>& material_names() const override { return none_; }
  absl::StatusOr<Ceiling> measure_ceiling(const render::TileRequest&, std::stop_token) const override {
    return Ceiling{};
  }
  std::size_t memory_bytes() const override { return 1000; }

 private:
  const std::uint64_t paint_;
  const std::vector<wire::ChannelDesc> channels_;
  const Events events_;
  const std::vector<std::string> none_;
};

/// Payload that an undisturbed worker of that rounding returns for a unit of the picture.
std::string right_payload(const v1::JobSpec& spec, std::uint64_t rounding, const v1::WorkUnit& unit);

}  // namespace tessera::test
