"""Network analyzers of other makers; analyzer.yaml names the class by this package alone."""

from gpr20_scikit_rf.mid.scikit_rf_analyzer import ScikitRfAnalyzer

__all__ = ["ScikitRfAnalyzer"]
