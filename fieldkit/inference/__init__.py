"""From readouts to drag and thrust: features in, a posterior of Cd and alpha out."""
