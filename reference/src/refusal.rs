//! Why a stage gives no result. Each variant names the requirement that asks for it.

use core::fmt;

/// Why a scan line gives no layers, no ROIs by one of its thresholds, or no layers of one format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineRefusal {
    /// LINE-2
    Width,
    /// THRESH-4
    LowContrast,
    /// REGION-5
    TooManyRegions,
    /// DECODE-2
    TooManyLayers,
}

/// Why an ROI gives no layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HypothesisRefusal {
    /// HYPO-12
    Repeated,
    /// HYPO-6
    TooFewBars,
    /// HYPO-7
    TooManyBars,
    /// HYPO-8
    CutOff,
    /// HYPO-9
    QuietZone,
    /// HYPO-11
    TooNarrow,
    /// HOMOG-3
    Implausible,
    /// SAMPLE-5
    Guard,
    /// SAMPLE-6, SAMPLE-8
    Transition,
    /// SAMPLE-10
    Residual,
}

/// Why a pair of layers gives no detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PairRefusal {
    /// CODE-7
    EqualHalves,
    /// CODE-8
    Crc,
}

/// Why a fit has no result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FitRefusal {
    /// FIT-12
    TooFewPixels,
    /// FIT-13
    NotConverged,
    /// FIT-13: the last step that may still lowers the sum of squares by as many times of what FIT-11 allows.
    Unfinished(f64),
}

/// Why a candidate is no detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CandidateRefusal {
    /// TRELLIS-7
    Unsettled,
    /// ACCEPT-10, ACCEPT-11
    NoFit,
    /// ACCEPT-2
    Disagree,
    /// ACCEPT-3
    Oblique,
    /// ACCEPT-4, ACCEPT-14
    Contrast,
    /// ACCEPT-5
    Blur,
    /// ACCEPT-6
    Misfit,
    /// ACCEPT-15
    Correlated,
    /// ACCEPT-16
    QuietZone,
    /// ACCEPT-7
    Margin,
    /// ACCEPT-12
    Undetermined,
    /// MERGE-10
    TooMany,
}

impl fmt::Display for LineRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Width => "the scan line is not as wide as the camera",
            Self::LowContrast => "the scan line has less than 24 grey levels of contrast",
            Self::TooManyRegions => "the scan line has more than 255 regions",
            Self::TooManyLayers => "the scan line has more than 8 decoded regions of interest",
        })
    }
}

impl fmt::Display for HypothesisRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Repeated => "the global threshold has read it already",
            Self::TooFewBars => "it has fewer bars than the guards",
            Self::TooManyBars => "it has more bars than the format",
            Self::CutOff => "it is cut off at an end of the line",
            Self::QuietZone => "it has no quiet zone",
            Self::TooNarrow => "it has less than 1.25 pixels per stripe",
            Self::Implausible => "no view of a barcode has this homography",
            Self::Guard => "a guard stripe does not fall in its region",
            Self::Transition => "its transitions are not the changes between its stripes",
            Self::Residual => "its transitions do not lie where the format has edges",
        })
    }
}

impl fmt::Display for PairRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::EqualHalves => "both layers are the same",
            Self::Crc => "the check byte is wrong",
        })
    }
}

impl fmt::Display for FitRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooFewPixels => "there are too few pixels between black and white",
            Self::NotConverged | Self::Unfinished(_) => "it has not converged",
        })
    }
}

impl fmt::Display for CandidateRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unsettled => "its most likely code word keeps changing",
            Self::NoFit => "no barcode can be fitted to its pixels",
            Self::Disagree => "its layers are not seen from one place",
            Self::Oblique => "no camera sees a barcode as obliquely as that",
            Self::Contrast => "its layers have no contrast, or not the same",
            Self::Blur => "it is more blurred than a barcode can be read",
            Self::Misfit => "a barcode does not explain its pixels",
            Self::Correlated => "what a barcode leaves of its pixels is no noise",
            Self::QuietZone => "it has no quiet zone within the line",
            Self::Margin => "another code word explains its pixels almost as well",
            Self::Undetermined => "the heading from which it is seen is undetermined",
            Self::TooMany => "the image has more than 8 detections",
        })
    }
}
