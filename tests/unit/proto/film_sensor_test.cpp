#include "wire/film_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "wire/aov_channels.h"
#include "wire/job_check.h"
#include "wire/resolve_settings.h"

namespace tessera::wire {
namespace {

using testing::AllOf;
using testing::HasSubstr;

v1::JobSpec job_of(v1::Color color, const std::string& integrator = "path") {
  v1::RenderSettings settings;
  settings.set_integrator(integrator);
  settings.set_color(color);
  v1::JobSpec job;
  resolve_settings(settings, job);
  return job;
}

std::string refusal(const v1::JobSpec& job) { return std::string(check_settings(job).message()); }

TEST(FilmSensor, UsualWordsGoWithEveryJob) {
  for (const v1::Color color : {v1::COLOR_RGB, v1::COLOR_SPECTRAL}) {
    v1::JobSpec job = job_of(color);
    EXPECT_EQ(job.view().sensor(), "cie1931");
    EXPECT_EQ(refusal(job), "");
    // Jobs of older versions have none of these words.
    job.mutable_view()->clear_sensor(), job.mutable_view()->clear_film();
    job.mutable_view()->clear_white_balance(), job.mutable_view()->clear_rgb_space();
    EXPECT_EQ(refusal(job), "");
    EXPECT_EQ(channels_of(job.view()).size(), 4u);
  }
}

TEST(FilmSensor, RgbHasNoWavelengthsToSee) {
  v1::JobSpec job = job_of(v1::COLOR_RGB);
  job.mutable_view()->set_sensor("nikon-d5100");
  job.mutable_view()->set_film("spectral:8");
  EXPECT_THAT(refusal(job),
              AllOf(HasSubstr("sensor 'nikon-d5100', film 'spectral:8'"), HasSubstr("'spectral'")));
  job.mutable_content()->mutable_algorithms()->set_color(v1::COLOR_SPECTRAL);
  EXPECT_EQ(refusal(job), "");
  job.mutable_view()->set_rgb_space(v1::RGB_SPACE_ACESCG);
  EXPECT_THAT(refusal(job), HasSubstr("rgb-space 'acescg' is for observers"));
}

TEST(FilmSensor, AllWordsThatMeanNothingAreTold) {
  v1::JobSpec job = job_of(v1::COLOR_SPECTRAL);
  job.mutable_view()->set_sensor("cie1932");
  job.mutable_view()->set_white_balance("D56");
  job.mutable_view()->set_film("spectral:0");
  EXPECT_THAT(refusal(job), AllOf(HasSubstr("sensor: there is no sensor 'cie1932'"),
                                  HasSubstr("white-balance: there is no illuminant 'D56'"),
                                  HasSubstr("film: a spectral film has 1 to 512 bands")));
}

TEST(FilmSensor, BandsAreChannelsBeforeThoseOfLayers) {
  v1::JobSpec job = job_of(v1::COLOR_SPECTRAL);
  job.mutable_view()->set_film("spectral:2:400-600");
  v1::Layer& layer = *job.mutable_view()->add_layers();
  layer.set_name("all"), layer.set_expression("C.*");
  const std::vector<ChannelDesc> channels = channels_of(job.view());
  ASSERT_EQ(channels.size(), 9u);
  EXPECT_EQ(channels[4].name, "S0.450,000000nm");
  EXPECT_EQ(channels[5].name, "S0.550,000000nm");
  EXPECT_EQ(channels[6].name, "all.R");
  job.mutable_view()->set_film("spectral:512");
  job.mutable_view()->clear_layers();
  EXPECT_EQ(refusal(job), "");
}

}  // namespace
}  // namespace tessera::wire
