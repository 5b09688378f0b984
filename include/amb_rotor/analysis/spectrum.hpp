#pragma once
// Amplitude spectra: of one channel, full spectrum of the plane (forward and backward), waterfall.
//
// Amplitude spectrum of u: A cos(2 pi f t + b) at a line's frequency shows A (not rms, not density):
//   A_k = 2 |sum w_n u_n exp(-2 pi i k n/N)| / (N G), G = sum w_n / N the window's coherent gain; the factor
//   2 is 1 at 0 and at half the sample rate.
// Full spectrum of z = x + i y: |sum w_n z_n exp(-2 pi i k n/N)| / (N G) at signed frequencies; a forward
// whirl
//   of radius r shows r at +f, a backward one r at -f.
// With segments the amplitudes are root mean squares over the segments (Welch 1967).
//
// Units: the unit of the signal; frequency [Hz]. Valid: equally spaced samples.
// Errors: InputError for bad options or lengths; a record shorter than one segment gives an empty result.
// Source: Harris, On the use of windows, Proc. IEEE 66 (1978); flat top of ISO 18431-2.
// Left out: phase (see harmonics.hpp for phase against the shaft), density scaling (divide by noise
// bandwidth).
#include <cstddef>
#include <string>
#include <vector>

namespace amb_rotor {

enum class Window { rectangular, hann, hamming, blackman, flat_top };

/// Periodic window of n values.
std::vector<double> windowValues(Window window, std::size_t n);

struct SpectrumOptions {
  Window window = Window::hann;
  bool remove_mean = true;         ///< takes each segment's mean out first, so that 0 Hz does not leak
  std::size_t segment_length = 0;  ///< samples; 0: the whole record is one segment
  double overlap = 0.5;            ///< of neighbouring segments, 0 <= overlap < 1
};

/// One-sided or full amplitude spectrum.
struct Spectrum {
  std::vector<double> frequency;  ///< [Hz] ascending; negative: backward (full spectrum only)
  std::vector<double> amplitude;
  double resolution = 0.0;       ///< [Hz] between lines
  double noise_bandwidth = 1.0;  ///< equivalent noise bandwidth of the window, in lines
  std::size_t segments = 0;
  Window window = Window::hann;
};

/// @throw InputError: sample rate not above 0, overlap outside [0, 1), value not finite.
Spectrum amplitudeSpectrum(const std::vector<double>& signal, double sample_rate,
                           const SpectrumOptions& options = {});

/// @throw InputError: as amplitudeSpectrum, or lengths differ.
Spectrum fullSpectrum(const std::vector<double>& x, const std::vector<double>& y, double sample_rate,
                      const SpectrumOptions& options = {});

/// A peak between the lines.
struct SpectralPeak {
  double frequency = 0.0;  ///< [Hz]
  double amplitude = 0.0;
};

/// The largest local maxima at or above a least amplitude, largest first. Frequency and amplitude are
/// interpolated: for the Hann window by the exact ratio of two lines of a single tone, else by a parabola
/// through the logarithms.
std::vector<SpectralPeak> spectralPeaks(const Spectrum& spectrum, std::size_t max_count,
                                        double least_amplitude = 0.0);

/// One line of a waterfall.
struct WaterfallLine {
  double time = 0.0;   ///< [s] middle of the segment; 0 in a cascade
  double speed = 0.0;  ///< mean of the segment, the caller's unit; 0 where not given
  std::vector<double> amplitude;
};

/// Spectra over time (waterfall) or over speed (cascade), on one frequency axis.
struct Waterfall {
  std::vector<double> frequency;  ///< [Hz]
  std::vector<WaterfallLine> lines;
};

/// Short-time spectra of one record. With y empty the one-sided spectrum of x, else the full spectrum.
/// @param speed value at each sample, or empty. @param start_time [s] of the first sample.
/// @throw InputError: as the spectra; segment_length 0.
Waterfall waterfall(const std::vector<double>& x, const std::vector<double>& y, double sample_rate,
                    const SpectrumOptions& options, const std::vector<double>& speed = {},
                    double start_time = 0.0);

/// Spectra of several records, sorted by speed. @throw InputError: counts or frequency axes differ.
Waterfall cascade(const std::vector<Spectrum>& spectra, const std::vector<double>& speed);

}  // namespace amb_rotor
