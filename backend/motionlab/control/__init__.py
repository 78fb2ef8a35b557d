"""What the controller computes in one period: position control, friction compensation, sharing."""
