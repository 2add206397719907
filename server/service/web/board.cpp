#include "service/web/board.h"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "scheduler/work_plan.h"
#include "service/web/json_text.h"
#include "service/web/picture.h"
#include "wire/aov_channels.h"
#include "wire/enum_words.h"

namespace tessera::server {
namespace {

using Json = nlohmann::ordered_json;

double seconds_of(const google::protobuf::Duration& duration) {
  return static_cast<double>(google::protobuf::util::TimeUtil::DurationToMilliseconds(duration)) / 1e3;
}

Json list_of(const google::protobuf::RepeatedPtrField<std::string>& texts) {
  Json list = Json::array();
  for (const std::string& text : texts) list.push_back(text);
  return list;
}

Json json_of(const v1::UnitFailure& failure) {
  return {{"host", failure.host()},
          {"message", failure.message()},
          {"lost", failure.lost()},
          {"log", list_of(failure.log())}};
}

/// Says where a layer's numbers come from, where that is not plain.
const char* about(const PictureLayer& layer) {
  if (layer.kind != PictureLayer::Kind::kNoise) return "";
  switch (layer.noise) {
    case PictureLayer::Noise::kSpread:
      return "Standard error of a pixel's luminance, from the spread of the means of its results. "
             "Nothing where there is one result.";
    case PictureLayer::Noise::kVariance:
      return "Standard error of a pixel's luminance, from the variance of its samples (--aov variance), as "
             "if they were independent: rather too much than too little.";
    case PictureLayer::Noise::kPilot:
      return "Standard error of a pixel's luminance that the job's pilot foresaw for its block of 8 x 8 "
             "pixels, by the samples that the pixel took, as if each counted for one pixel: rather too much "
             "than too little. With --aov variance it is measured.";
  }
  return "";
}

Json settings_of(const v1::JobSpec& spec) {
  const v1::PixelRect& crop = spec.cut().crop();
  Json layers = Json::array();
  for (const PictureLayer& layer : layers_of(wire::channels_of(spec.view()), spec.samples().noise() > 0))
    layers.push_back({{"name", layer.name}, {"color", layer.is_color()}, {"about", about(layer)}});
  return {{"width", spec.view().width()},
          {"height", spec.view().height()},
          {"crop", {crop.x0(), crop.y0(), crop.x1(), crop.y1()}},
          {"level", Picture::level_for({crop.x0(), crop.y0(), crop.x1(), crop.y1()})},
          {"spp", spec.samples().spp()},
          {"noise", spec.samples().noise()},
          {"integrator", spec.content().algorithms().integrator()},
          {"seed", spec.view().seed()},
          {"layers", std::move(layers)},
          {"tags", list_of(spec.farm().required_tags())}};
}

}  // namespace

std::string row_of(const v1::JobStatus& job) {
  Json row{{"id", job.job_id()},
           {"name", job.name()},
           {"user", job.user()},
           {"state", v1::JobState_Name(job.state())},
           {"paused", job.paused()},
           {"priority", job.priority()},
           {"done", job.units_done()},
           {"total", job.units_total()},
           {"leased", job.units_leased()},
           {"aside", job.units_set_aside()},
           {"failures", job.failures()},
           {"workers", job.workers()},
           {"cpu", std::round(10 * seconds_of(job.stats().cpu_time())) / 10},
           {"submitted", job.submitted_unix_ms()},
           {"finished", job.finished_unix_ms()},
           {"left", (job.left_ms() + 500) / 1000},
           {"phase", job.phase()},
           {"error", job.error()}};
  if (!job.group().empty()) {
    row["group"] = job.group();
    row["frame"] = job.frame();
  }
  return json_text(row);
}

std::string row_of(const v1::WorkerStatus& worker, std::chrono::milliseconds heartbeats) {
  Json jobs = Json::array();
  for (const v1::WorkerJob& job : worker.jobs())
    jobs.push_back({{"id", job.job_id()}, {"name", job.name()}, {"leases", job.leases()}});
  // A worker that is well is heard of that often, give or take what the way takes.
  const bool missed = worker.last_seen_ms_ago() > heartbeats.count() * 8 / 5;
  return json_text(Json{{"id", worker.worker_id()},
                        {"name", worker.name()},
                        {"host", worker.host()},
                        {"isa", worker.isa()},
                        {"build", worker.build()},
                        {"threads", worker.threads()},
                        {"leases", worker.leases()},
                        {"done", worker.units_done()},
                        {"failures", worker.failures()},
                        {"memory", worker.resident_bytes() >> 20},
                        {"slowness", std::round(10 * worker.slowness()) / 10},
                        {"draining", worker.draining()},
                        {"silent", missed ? (worker.last_seen_ms_ago() + 999) / 1000 : 0},
                        {"quarantine", worker.quarantine()},
                        {"tags", list_of(worker.tags())},
                        {"jobs", std::move(jobs)}});
}

std::string details_of(const v1::GetJobResponse& job) {
  const v1::JobStatus& status = job.status();
  Json aside = Json::array(), latest = Json::array(), slow = Json::array();
  for (const v1::SetAsideUnit& unit : status.set_aside()) {
    Json failures = Json::array();
    for (const v1::UnitFailure& failure : unit.failures()) failures.push_back(json_of(failure));
    Json row{{"unit", unit.unit().index()}, {"failures", std::move(failures)}};
    if (unit.unit().has_tile() || unit.unit().has_pass()) {
      const v1::PixelRect pixels = extent_of(unit.unit(), job.spec()).pixels();
      row["pixels"] = {pixels.x0(), pixels.y0(), pixels.x1(), pixels.y1()};
    }
    aside.push_back(std::move(row));
  }
  for (const v1::FailedUnit& unit : status.latest_failures()) {
    Json row = json_of(unit.failure());
    row["unit"] = unit.unit_index();
    latest.push_back(std::move(row));
  }
  for (const v1::SlowHost& host : job.slow_hosts())
    slow.push_back({{"host", host.host()}, {"slowness", std::round(10 * host.slowness()) / 10}});
  return json_text(Json{{"id", status.job_id()},
                        {"settings", settings_of(job.spec())},
                        {"aside", std::move(aside)},
                        {"latest", std::move(latest)},
                        {"slow", std::move(slow)},
                        {"notes", list_of(status.notes())},
                        {"warnings", list_of(status.stats().warnings())},
                        {"waiting", status.waiting_for()},
                        {"left_out", status.left_out()},
                        {"adopted", status.units_adopted()},
                        {"adopted_from", status.adopted_from()},
                        {"samples", status.stats().samples()},
                        {"error", status.error()}});
}

void Board::update(Rows rows) {
  ++round_;
  const std::uint64_t next = version_ + 1;
  for (auto& [name, json] : rows) {
    const auto [found, added] = rows_.try_emplace(std::move(name));
    Row& row = found->second;
    row.last_seen_round = round_;
    if (added) row.order = ++order_;
    if (!added && row.json == json) continue;
    row.json = std::move(json);
    row.version = version_ = next;
  }
  for (auto row = rows_.begin(); row != rows_.end();) {
    if (row->second.last_seen_round == round_) {
      ++row;
      continue;
    }
    version_ = next;
    gone_.emplace_back(next, row->first);
    row = rows_.erase(row);
  }
  while (gone_.size() > kMostGone) {
    forgotten_ = gone_.front().first;
    gone_.pop_front();
  }
}

Board::News Board::since(std::uint64_t version) const {
  News news{.rows = {}, .gone = {}, .all = version == 0 || version < forgotten_};
  std::vector<const Row*> newer;
  for (const auto& [name, row] : rows_) {
    if (news.all || row.version > version) newer.push_back(&row);
  }
  std::ranges::sort(newer, {}, &Row::order);
  for (const Row* row : newer) news.rows.push_back(row->json);
  if (news.all) return news;
  for (const auto& [at, name] : gone_) {
    if (at > version) news.gone.push_back(name);
  }
  return news;
}

}  // namespace tessera::server
