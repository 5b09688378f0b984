// Spectra of single tones: amplitude, direction, windows, waterfall.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

#include "amb_rotor/analysis/spectrum.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

constexpr double rate = 1000.0;
// FFT of n = 1000: round-off of a few 1e-15 of the largest line.
constexpr double spectrum_round_off = 1e-12;

std::vector<double> tone(double amplitude, double frequency, double phase, std::size_t n) {
  std::vector<double> u(n);
  for (std::size_t i = 0; i < n; ++i) u[i] = amplitude * std::cos(2.0 * M_PI * frequency * i / rate + phase);
  return u;
}

TEST(AnalysisSpectrum, EveryWindowShowsTheAmplitudeOfALine) {
  std::vector<double> u = tone(1.7, 80.0, 0.6, 1000);
  for (double& value : u) value += 5.0;
  for (Window window :
       {Window::rectangular, Window::hann, Window::hamming, Window::blackman, Window::flat_top}) {
    SpectrumOptions options;
    options.window = window;
    const Spectrum s = amplitudeSpectrum(u, rate, options);
    ASSERT_EQ(s.frequency.size(), 501u);
    EXPECT_NEAR(s.frequency[80], 80.0, spectrum_round_off);
    EXPECT_NEAR(s.amplitude[80], 1.7, spectrum_round_off);
    EXPECT_NEAR(s.amplitude[0], 0.0, spectrum_round_off);  // the mean is taken out
    EXPECT_NEAR(s.amplitude[300], 0.0, spectrum_round_off);
  }
  SpectrumOptions keep;
  keep.remove_mean = false;
  EXPECT_NEAR(amplitudeSpectrum(u, rate, keep).amplitude[0], 5.0, spectrum_round_off);
}

TEST(AnalysisSpectrum, NoiseBandwidthOfKnownWindows) {
  SpectrumOptions options;
  EXPECT_NEAR(amplitudeSpectrum(tone(1, 80, 0, 1000), rate, options).noise_bandwidth, 1.5,
              1e-12);  // Hann, exact
  options.window = Window::flat_top;
  // Table value 3.77 (Harris; ISO 18431-2), three digits.
  EXPECT_NEAR(amplitudeSpectrum(tone(1, 80, 0, 1000), rate, options).noise_bandwidth, 3.77, 0.005);
}

TEST(AnalysisSpectrum, HalfTheSampleRateIsNotDoubled) {
  SpectrumOptions options;
  options.window = Window::rectangular;
  const Spectrum s = amplitudeSpectrum(tone(1.0, 500.0, 0.0, 1000), rate, options);
  EXPECT_NEAR(s.amplitude[500], 1.0, spectrum_round_off);
}

TEST(AnalysisSpectrum, FlatTopBetweenLines) {
  SpectrumOptions options;
  options.window = Window::flat_top;
  const Spectrum s = amplitudeSpectrum(tone(1.0, 80.5, 0.0, 1000), rate, options);
  // Scalloping of the flat top: 0.01 dB = 0.12 %.
  EXPECT_NEAR(s.amplitude[80], 1.0, 2e-3);
}

TEST(AnalysisSpectrum, FullSpectrumTellsForwardFromBackward) {
  for (std::size_t n : {1000u, 999u}) {
    std::vector<double> x, y;
    const double df = rate / n;
    for (std::size_t i = 0; i < n; ++i) {
      const double t = i / rate;
      const std::complex<double> z =
          std::polar(2.0, 2.0 * M_PI * 50 * df * t) + std::polar(0.5, -2.0 * M_PI * 120 * df * t + 1.0);
      x.push_back(z.real());
      y.push_back(z.imag());
    }
    const Spectrum s = fullSpectrum(x, y, rate);
    const std::vector<SpectralPeak> peaks = spectralPeaks(s, 5, 0.01);
    ASSERT_EQ(peaks.size(), 2u);
    EXPECT_NEAR(peaks[0].frequency, 50 * df, 1e-9);
    EXPECT_NEAR(peaks[0].amplitude, 2.0, 1e-9);
    EXPECT_NEAR(peaks[1].frequency, -120 * df, 1e-9);
    EXPECT_NEAR(peaks[1].amplitude, 0.5, 1e-9);
    EXPECT_TRUE(std::is_sorted(s.frequency.begin(), s.frequency.end()));
  }
}

TEST(AnalysisSpectrum, PeakBetweenLines) {
  const Spectrum s = amplitudeSpectrum(tone(1.3, 80.37, 0.4, 1000), rate);
  const auto peaks = spectralPeaks(s, 1);
  ASSERT_EQ(peaks.size(), 1u);
  // Exact for one complex tone; the mirror tone 160 lines away leaks (Hann falls with the cube): 1e-6.
  EXPECT_NEAR(peaks[0].frequency, 80.37, 1e-5);
  EXPECT_NEAR(peaks[0].amplitude, 1.3, 1e-5);
}

TEST(AnalysisSpectrum, SegmentsAverageThePower) {
  std::mt19937 generator(1);
  std::normal_distribution<double> noise;
  std::vector<double> u(64000);
  for (double& value : u) value = noise(generator);
  SpectrumOptions options;
  options.segment_length = 1000;
  const Spectrum s = amplitudeSpectrum(u, rate, options);
  EXPECT_EQ(s.segments, 127u);
  double mean_square = 0.0;
  for (std::size_t i = 1; i < 500; ++i) mean_square += 0.5 * s.amplitude[i] * s.amplitude[i];
  // Parseval with the noise bandwidth: variance 1 = sum A^2/2 / bandwidth. Standard error sqrt(2/64000) = 0.6
  // %; the two end lines hold 0.2 %.
  EXPECT_NEAR(mean_square / s.noise_bandwidth, 1.0, 0.025);
}

TEST(AnalysisSpectrum, WaterfallFollowsASweep) {
  // Frequency 50 + 100 t [Hz] over 2 s.
  std::vector<double> x, y, speed;
  for (std::size_t i = 0; i < 2000; ++i) {
    const double t = i / rate, phase = 2.0 * M_PI * (50.0 * t + 50.0 * t * t);
    x.push_back(std::cos(phase));
    y.push_back(-std::sin(phase));
    speed.push_back(50.0 + 100.0 * t);
  }
  SpectrumOptions options;
  options.segment_length = 200;
  const Waterfall w = waterfall(x, y, rate, options, speed, 3.0);
  ASSERT_EQ(w.lines.size(), 19u);
  EXPECT_NEAR(w.lines[0].time, 3.0 + 0.0995, 1e-12);
  for (const WaterfallLine& line : w.lines) {
    const auto top = std::max_element(line.amplitude.begin(), line.amplitude.end());
    // Backward; one line is 5 Hz.
    EXPECT_NEAR(w.frequency[static_cast<std::size_t>(top - line.amplitude.begin())], -line.speed, 5.0);
  }
  EXPECT_EQ(waterfall(x, {}, rate, options).frequency.size(), 101u);
}

TEST(AnalysisSpectrum, CascadeIsSortedBySpeed) {
  const Spectrum a = amplitudeSpectrum(tone(1, 10, 0, 100), rate),
                 b = amplitudeSpectrum(tone(2, 10, 0, 100), rate);
  const Waterfall w = cascade({a, b}, {30.0, 20.0});
  EXPECT_EQ(w.lines[0].speed, 20.0);
  EXPECT_NEAR(w.lines[0].amplitude[1], 2.0, spectrum_round_off);
  EXPECT_THROW(cascade({a, amplitudeSpectrum(tone(1, 10, 0, 200), rate)}, {1.0, 2.0}), InputError);
}

TEST(AnalysisSpectrum, BadInput) {
  EXPECT_THROW(amplitudeSpectrum({1.0, NAN}, rate), InputError);
  EXPECT_THROW(amplitudeSpectrum({1.0, 2.0}, 0.0), InputError);
  SpectrumOptions options;
  options.overlap = 1.0;
  EXPECT_THROW(amplitudeSpectrum({1.0, 2.0}, rate, options), InputError);
  EXPECT_TRUE(amplitudeSpectrum({}, rate).frequency.empty());
}

}  // namespace
}  // namespace amb_rotor
